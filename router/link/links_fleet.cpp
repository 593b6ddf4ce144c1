// Links, the part that finds other routers in the fleet.
#include <algorithm>

#include "router/core/random.h"
#include "router/link/links.h"

namespace tims::link {
namespace {

using namespace std::chrono_literals;

// Keep-alives, 9 s: so long has UDP to bring up a link to a new router. Of a fleet that starts at
// once on a busy machine some take seconds, which is not the time to begin with DDS.
constexpr int kUdpFirst = 30;
constexpr Duration kDdsTurn = 500ms;  // to prepare a way over DDS, of each router of the fleet
// With more routers in the fleet none is prepared before it is needed.
constexpr std::size_t kStandbyFleetMax = 100;

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

// What a way over DDS costs the router above grows with how many it has already. So where UDP is
// there as well, routers that start at once take turns, each side by itself, and none prepares more
// than a few a second. A link that is down although UDP had time enough needs this way now, and
// goes before those that only take their turn; but when all are too busy to answer they are all
// down, so no more are prepared a second for it. In a large fleet nobody has a turn: what many
// ways ask of the router above while nobody needs them is what it then lacks to hear its links.
Time Links::dds_turn(Time now, const Link& link, Turn& turn) {
  if (!link.is_up() && !link.settings().connects) return kNever;  // it calls nobody
  if (turn.since == kNever) {
    std::uint64_t drawn = random();
    turn.since = now;
    turn.share = core::next_share(drawn);
  }
  const std::size_t others = fleet_.routers().size();
  const auto all = static_cast<double>(others) * kDdsTurn;
  const Duration keep_alive = link.settings().keep_alive;
  const Time turns_at =
      others > kStandbyFleetMax
          ? kNever
          : turn.since + keep_alive + std::chrono::duration_cast<Duration>(turn.share * all);
  const Time needed_at =
      link.is_up() ? kNever
                   : std::max(turn.since + kUdpFirst * keep_alive, link.since() + keep_alive);
  if (now < std::min(turns_at, needed_at)) return std::min(turns_at, needed_at);
  const Time ready_at = dds_budget_.ready_at(now);
  if (now < needed_at) return std::max(ready_at, dds_needed_until_);
  if (now < ready_at) dds_needed_until_ = ready_at + 1s / kDdsWaysPerSecond;
  return ready_at;
}

// Leaves those to which the way may be prepared now.
void Links::take_turn(Time now, const Link& link, std::vector<NetAddress>& dds) {
  Turn& turn = turns_[link.slot()];
  const auto waits = [&](const NetAddress& to) {
    return std::ranges::find(turn.prepared, to) == turn.prepared.end();
  };
  const Path* udp = link.paths().find(PathKind::kUdp);
  const bool by_dds = link.is_up() && link.paths().kind() == PathKind::kDds;
  turn.at = kNever;
  if (udp != nullptr && !udp->targets.empty() && !by_dds && std::ranges::any_of(dds, waits)) {
    turn.at = dds_turn(now, link, turn);
    if (turn.at > now) {
      std::erase_if(dds, waits);
      return;
    }
    dds_budget_.take(1);
  }
  turn = {.prepared = dds};
}

// Tells a link where the router it means has announced to be.
void Links::look_for(Time now, Link& link) {
  touch(link);
  const std::vector<const Announcement*> candidates = fleet_.candidates(link, supers_.size() < 2);
  const bool automatic = link.settings().is_automatic();
  if (candidates.empty()) {
    link.set_targets(now, PathKind::kDds, {});
    turns_[link.slot()] = {};
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
  take_turn(now, link, dds);
  link.set_targets(now, PathKind::kDds, dds);
}

}  // namespace tims::link
