#include "router/link/fleet.h"

#include <algorithm>
#include <tuple>

namespace tims::link {

bool Fleet::add(const Announcement& announcement) {
  if (!announcement.dds || announcement.who.epoch == self_.epoch) return false;
  Announcement& known = routers_[announcement.dds];
  if (known == announcement) return false;
  known = announcement;
  return true;
}

void Fleet::remove(const NetAddress& dds) { routers_.erase(dds); }

std::string Fleet::looked_for() const {
  if (self_.role == Role::kSystem) return "a top-level router";
  return "a system router of system " + std::to_string(self_.system);
}

bool Fleet::is_double(const Identity& who) const {
  return who.epoch != self_.epoch && who.system == self_.system && who.id == self_.id;
}

std::vector<const Announcement*> Fleet::candidates(const Link& link, bool alone) const {
  std::vector<const Announcement*> all;
  const Path* udp = link.paths().find(PathKind::kUdp);
  const bool above = link.settings().kind == LinkKind::kSuper && link.settings().connects &&
                     (link.settings().is_automatic() || (alone && udp == nullptr));
  const auto is_called = [&](const Announcement& a) {
    return !link.settings().is_automatic() && udp != nullptr &&
           std::ranges::any_of(a.udp, [&](const NetAddress& to) { return udp->is_target(to); });
  };
  const auto is_linked = [&](const Announcement& a) {
    return link.peer().epoch != 0 && a.who.epoch == link.peer().epoch;
  };
  for (const auto& [from, a] : routers_) {
    if (is_linked(a) && link.is_up()) return {&a};
    if (is_linked(a) || is_called(a) || (above && is_above(a.who, self_))) all.push_back(&a);
  }
  std::ranges::sort(all, {}, [&](const Announcement* a) {
    return std::tuple(!is_linked(*a), !is_called(*a), a->who.system, a->who.id, a->who.epoch);
  });
  return all;
}

}  // namespace tims::link
