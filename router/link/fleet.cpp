#include "router/link/fleet.h"

#include <algorithm>
#include <tuple>

#include "router/core/random.h"

namespace tims::link {
namespace {

using namespace std::chrono_literals;

// In keep-alives (9 s): how long UDP has to bring up a link to a new router. When a whole fleet
// starts at once on a busy machine, some links take seconds; starting DDS then would add load.
constexpr int kUdpFirst = 30;
// Spacing between the routers of the fleet when they prepare DDS paths.
constexpr Duration kStandbySpacing = 500ms;
// With more routers in the fleet, paths are prepared only when needed.
constexpr std::size_t kStandbyFleetMax = 100;

}  // namespace

bool Fleet::add(const Announcement& announcement) {
  const NetAddress& dds = announcement.dds;
  const bool is_dds = dds && dds.kind == PathKind::kDds;
  if (!is_dds || announcement.identity.epoch == self_.epoch) return false;
  const auto known = routers_.find(dds);
  if (known == routers_.end())
    return routers_.size() < kRoutersMax && routers_.emplace(dds, announcement).second;
  if (known->second == announcement) return false;
  known->second = announcement;
  return true;
}

void Fleet::remove(const NetAddress& dds) { routers_.erase(dds); }

std::string Fleet::looked_for() const {
  if (self_.role == Role::kSystem) return "a top-level router";
  return "a system router of system " + std::to_string(self_.system);
}

bool Fleet::is_double(const Identity& identity) const {
  return identity.epoch != self_.epoch && identity.system == self_.system &&
         identity.id == self_.id;
}

std::vector<const Announcement*> Fleet::candidates(const Link& link, bool alone) const {
  std::vector<const Announcement*> all;
  const Path* udp = link.paths().find(PathKind::kUdp);
  const bool above = link.settings().kind == LinkKind::kSuper && link.settings().connects &&
                     (link.settings().is_automatic() || (alone && udp == nullptr));
  const auto is_called = [&](const Announcement& a) {
    return !link.settings().is_automatic() &&
           std::ranges::any_of(a.udp, [&](const NetAddress& to) { return link.is_named(to); });
  };
  const auto is_linked = [&](const Announcement& a) {
    return link.peer().epoch != 0 && a.identity.epoch == link.peer().epoch;
  };
  for (const auto& [from, a] : routers_) {
    if (is_linked(a) || is_called(a) || (above && is_above(a.identity, self_))) all.push_back(&a);
  }
  // It may be announced twice: its former process of DDS has died, and its announcement has not
  // expired yet.
  if (link.is_up() && std::ranges::any_of(all, [&](const auto* a) { return is_linked(*a); }))
    std::erase_if(all, [&](const auto* a) { return !is_linked(*a); });
  std::ranges::sort(all, {}, [&](const Announcement* a) {
    return std::tuple(!is_linked(*a), !is_called(*a), a->identity.system, a->identity.id,
                      a->identity.epoch);
  });
  return all;
}

// --- standby paths over DDS

Time StandbyTurns::turn_at(Time now, const Link& link, std::size_t others, LinkContext& context,
                           Turn& standby) {
  if (!link.is_up() && !link.settings().connects) return kNever;  // it does not initiate
  if (standby.since == kNever) {
    std::uint64_t drawn = context.random();
    standby.since = now;
    standby.share = core::next_share(drawn);
  }
  const auto all = static_cast<double>(others) * kStandbySpacing;
  const Duration keep_alive = link.settings().keep_alive;
  const Time standby_turn_at =
      others > kStandbyFleetMax
          ? kNever
          : standby.since + keep_alive + std::chrono::duration_cast<Duration>(standby.share * all);
  // A router that refuses the call over UDP may accept it over DDS.
  const int udp_first = link.state() == Link::State::kRefused ? 1 : kUdpFirst;
  const Time needed_at =
      link.is_up() ? kNever
                   : std::max(standby.since + udp_first * keep_alive, link.since() + keep_alive);
  if (now < std::min(standby_turn_at, needed_at)) return std::min(standby_turn_at, needed_at);
  const Time ready_at = budget_.ready_at(now);
  if (now < needed_at) return std::max(ready_at, needed_until_);
  if (now < ready_at) needed_until_ = ready_at + 1s / kPathsPerSecond;
  return ready_at;
}

void StandbyTurns::prepare(Time now, const Link& link, std::size_t others, LinkContext& context,
                           Turn& standby, std::vector<NetAddress>& dds) {
  const auto waits = [&](const NetAddress& to) {
    return std::ranges::find(standby.prepared, to) == standby.prepared.end();
  };
  const Path* udp = link.paths().find(PathKind::kUdp);
  const bool by_dds = link.is_up() && link.paths().kind() == PathKind::kDds;
  standby.at = kNever;
  if (udp != nullptr && !udp->targets.empty() && !by_dds && std::ranges::any_of(dds, waits)) {
    standby.at = turn_at(now, link, others, context, standby);
    if (standby.at > now) {
      std::erase_if(dds, waits);
      return;
    }
    budget_.take(1);
  }
  standby = {.prepared = dds};
}

}  // namespace tims::link
