// The routers of the fleet as they announce themselves and the candidates for each link (Fleet),
// and when a DDS path to one of them is prepared (StandbyTurns).
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
  // Further routers are not taken: everybody on the network may announce some.
  static constexpr std::size_t kRoutersMax = 4096;

  explicit Fleet(const Identity& self) : self_(self) {}

  // Returns false when it was known already, is our own, or is not announced over DDS; or when
  // there are too many.
  bool add(const Announcement& announcement);
  void remove(const NetAddress& dds);

  // The routers that may be at the other end of a link, most likely first: the linked router,
  // alone while the link is up; then the router at the address the link connects to. For a super
  // link to "auto", or one that is `alone` because it cannot use an address: routers with the
  // role above ours; for the super routers of a subsystem, only those of our system.
  [[nodiscard]] std::vector<const Announcement*> candidates(const Link& link, bool alone) const;
  // Description of the router a super link looks for: "a system router of system 3".
  [[nodiscard]] std::string looked_for() const;
  // True for another router with our system and id.
  [[nodiscard]] bool is_double(const Identity& identity) const;

  [[nodiscard]] const std::map<NetAddress, Announcement>& routers() const { return routers_; }

 private:
  const Identity self_;
  // Keyed by the source address of the announcement.
  std::map<NetAddress, Announcement> routers_;
};

// Decides when a link that also has UDP prepares its DDS path.
//
// Each additional path makes all paths of the router above more expensive. Therefore, where UDP
// is available as well, routers that start at the same time take turns, each side on its own, and
// no router prepares more than a few paths per second. A link that is down although UDP had
// enough time needs its DDS path now and precedes those that only wait for their turn; the rate
// stays the same, because when all routers are too busy to answer, all links are down. In a large
// fleet no path is prepared before it is needed: unused paths would cost the router above the time
// it needs to serve its links.
class StandbyTurns {
 public:
  // Paths that one router prepares per second where UDP is available as well; also the burst size.
  static constexpr std::uint64_t kPathsPerSecond = 10;

  // State of one link.
  struct Turn {
    std::vector<NetAddress> prepared{};
    Time since = kNever;  // start of waiting
    double share = 0;     // position within the spread of all turns, 0 to 1
    Time at = kNever;     // when to ask again
  };
  // Removes the targets whose path may not be prepared yet. `others`: number of other routers in
  // the fleet.
  void prepare(Time now, const Link& link, std::size_t others, LinkContext& context, Turn& standby,
               std::vector<NetAddress>& dds);

 private:
  Time turn_at(Time now, const Link& link, std::size_t others, LinkContext& context, Turn& standby);

  base::RateLimiter budget_{kPathsPerSecond, kPathsPerSecond};  // limits prepared paths
  Time needed_until_{};  // a link that needs its path waits for the budget
};

}  // namespace tims::link
