// How large datagrams may be: found by sending larger ones and seeing whether they arrive, without
// any help from routers on the way (DPLPMTUD, RFC 8899). 1200 bytes always pass. When datagrams
// larger than that keep being lost, the path has changed, and it begins again at 1200.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "router/link/datagram.h"
#include "tims/time.h"

namespace tims::link {

class PathMtu {
 public:
  [[nodiscard]] std::size_t size() const { return size_; }

  // The size to try now, as a datagram of its own and not above `most`; 0: none.
  [[nodiscard]] std::size_t probe(Time now, std::size_t most) const;
  [[nodiscard]] Time next_probe(std::size_t most) const {
    const bool tries = !probing_ && step_ < kSteps.size() && kSteps[step_] <= most;
    return tries ? next_ : kNever;
  }
  void on_probe_sent(std::size_t size);
  void on_probe_acked(Time now, std::size_t size);
  void on_probe_lost(Time now);

  // An ordinary datagram. True when the size was reduced.
  void on_acked(std::size_t datagram);
  bool on_lost(Time now, std::size_t datagram);
  void reset(Time now);  // another path
  // One that takes any datagram up to this, and none larger: nothing is tried.
  void fix(std::size_t size);

 private:
  // Ethernet less IPv6 and UDP, less IPv4 and UDP; steps of overlays; jumbo frames.
  static constexpr std::array<std::size_t, 7> kSteps{1372, 1432, 1452,        1472,
                                                     4052, 8952, kDatagramMax};
  static constexpr int kTries = 3;
  static constexpr int kBlackHole = 6;  // large ones lost in a row
  static constexpr Duration kTryAgain = std::chrono::minutes(5);
  static constexpr Duration kBetween = std::chrono::milliseconds(20);

  std::size_t size_ = kDatagramBase;
  std::size_t step_ = 0;  // of kSteps, to be tried next
  bool fixed_ = false;
  bool probing_ = false;
  int tries_ = 0;
  int lost_in_a_row_ = 0;
  Time next_{};
};

}  // namespace tims::link
