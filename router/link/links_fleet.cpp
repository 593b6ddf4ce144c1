// Links, the part that finds other routers in the fleet.
#include "router/core/random.h"
#include "router/link/links.h"

namespace tims::link {
namespace {

constexpr Duration kDdsSettle = std::chrono::milliseconds(100);  // to hear who else there is
constexpr Duration kDdsTurn = std::chrono::milliseconds(100);    // of each of them

}  // namespace

void Links::on_announced(Time now, const Announcement& announcement) {
  now_ = now;
  if (!fleet_.add(announcement)) return;
  const Identity& who = announcement.who;
  if (fleet_.is_double(who))
    router_.note({.at = now,
                  .kind = core::EventKind::kDuplicateRouter,
                  .address = who.address(),
                  .client = {.port = core::PortKind::kLink,
                             .name = core::Text<31>(who.name.view()),
                             .peer = std::string_view(announcement.dds.to_string())},
                  .owner = {.port = core::PortKind::kLink,
                            .name = core::Text<31>(setup_.self.name.view()),
                            .peer = std::string_view("this router")}});
  look_for_all(now);
}

void Links::on_gone(Time now, const NetAddress& dds) {
  now_ = now;
  fleet_.remove(dds);
  for (const auto& link : links_) {
    if (link) link->on_gone(now, dds);
  }
  look_for_all(now);
}

void Links::look_for_all(Time now) {
  for (const auto& link : links_) {
    if (link) look_for(now, *link);
  }
}

// It has come up: that one is meant from now on. Or it is down: any may be.
void Links::look_anew(Time now, Link& link) {
  were_up_[link.slot()] = link.is_up();
  tries_[link.slot()] = 0;
  look_for(now, link);
}

// What a way over DDS costs the router above grows with how many it has already. So routers that
// start at once take turns, each side by itself.
bool Links::waits_for_dds(Time now, const Link& link) {
  if (link.paths().find(PathKind::kUdp) == nullptr) return false;
  Turn& turn = turns_[link.slot()];
  if (turn.at == kNever) turn.at = now + kDdsSettle;
  if (now >= turn.at && !turn.is_drawn) {
    std::uint64_t drawn = random();
    const double share = core::next_share(drawn);
    const auto all = static_cast<double>(fleet_.routers().size()) * kDdsTurn;
    turn = {.at = now + std::chrono::duration_cast<Duration>(share * all), .is_drawn = true};
  }
  return turn.is_awaited = now < turn.at;
}

// Tells a link where the router it means has announced to be.
void Links::look_for(Time now, Link& link) {
  touch(link);
  const std::vector<const Announcement*> candidates = fleet_.candidates(link, supers_.size() < 2);
  const bool automatic = link.settings().is_automatic();
  if (candidates.empty()) {
    link.set_targets(now, PathKind::kDds, {});
    if (!automatic) return;
    link.set_targets(now, PathKind::kUdp, {});
    const std::string why = "nobody in the fleet is " + fleet_.looked_for();
    return link.note_nobody(why);
  }
  const Announcement& one = *candidates[tries_[link.slot()] % candidates.size()];
  // A router that was started anew is heard of while its former life still is.
  std::vector<NetAddress> udp;
  std::vector<NetAddress> dds;
  for (const Announcement* a : candidates) {
    if (a->who.system != one.who.system || a->who.id != one.who.id) continue;
    udp.insert(udp.end(), a->udp.begin(), a->udp.end());
    dds.push_back(a->dds);
  }
  if (automatic || !link.settings().connects) link.set_targets(now, PathKind::kUdp, udp);
  if (waits_for_dds(now, link)) dds.clear();
  link.set_targets(now, PathKind::kDds, dds);
}

}  // namespace tims::link
