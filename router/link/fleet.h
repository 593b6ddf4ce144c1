// The routers of the fleet as they announce themselves, which of them a link means (Fleet), and
// when a path over DDS to one of them is prepared (StandbyTurns).
#pragma once

#include <map>
#include <string>
#include <vector>

#include "base/rate_limiter.h"
#include "router/link/datagram.h"
#include "router/link/link.h"

namespace tims::link {

class Fleet {
 public:
  explicit Fleet(const Identity& self) : self_(self) {}

  // False: this was known, or it is our own.
  bool add(const Announcement& announcement);
  void remove(const NetAddress& dds);

  // Who may be at the other end of a link, the likeliest first: the router it is linked with, and
  // nobody else while that is up; who has the address that the link is to connect to. For a super
  // link that says "auto", or has no use for an address and is `alone`, who has the role above
  // ours; of a subsystem's super routers those of our system.
  [[nodiscard]] std::vector<const Announcement*> candidates(const Link& link, bool alone) const;
  // What a super link looks for, in words: "a system router of system 3".
  [[nodiscard]] std::string looked_for() const;
  // Is this another router with our system and id?
  [[nodiscard]] bool is_double(const Identity& who) const;

  [[nodiscard]] const std::map<NetAddress, Announcement>& routers() const { return routers_; }

 private:
  const Identity self_;
  std::map<NetAddress, Announcement> routers_;  // by where they announce themselves from
};

// When a link that has UDP as well prepares its path over DDS.
//
// What such a path costs the router above grows with how many it has already. So where UDP is
// there as well, routers that start at once take turns, each side by itself, and none prepares more
// than a few a second. A link that is down although UDP had time enough needs this path now, and
// goes before those that only take their turn; but when all are too busy to answer they are all
// down, so no more are prepared a second for it. In a large fleet nobody has a turn: what many
// paths ask of the router above while nobody needs them is what it then lacks to hear its links.
class StandbyTurns {
 public:
  // Paths that one router prepares, where UDP is there as well; as many at once.
  static constexpr std::uint64_t kPathsPerSecond = 10;

  // One link's.
  struct Turn {
    std::vector<NetAddress> prepared{};
    Time since = kNever;  // others wait to be
    double share = 0;     // of the turns of all
    Time at = kNever;     // to ask again
  };
  // Leaves those to which the path may be prepared now. `others`: routers of the fleet.
  void prepare(Time now, const Link& link, std::size_t others, LinkContext& context, Turn& standby,
               std::vector<NetAddress>& dds);

 private:
  Time turn_at(Time now, const Link& link, std::size_t others, LinkContext& context, Turn& standby);

  base::RateLimiter budget_{kPathsPerSecond, kPathsPerSecond};  // paths prepared
  Time needed_until_{};  // a link that needs its path waits for the budget
};

}  // namespace tims::link
