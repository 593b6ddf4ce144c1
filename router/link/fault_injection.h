// A simulated bad network: decides the fate of each datagram from a seed. The simulator's network
// consists of these; the real socket sends through one on request (`timsctl sim fault`).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "tims/time.h"

namespace tims::link {

struct Faults {
  double loss = 0;  // fraction of datagrams, 0 to 1
  double duplicate = 0;
  double reorder = 0;  // fraction of the datagrams that are delayed
  Duration held_back = std::chrono::milliseconds(5);
  Duration delay{};
  Duration jitter{};               // additional delay up to this, without changing the order
  std::uint64_t rate = 0;          // bytes per second; 0: no limit
  std::uint64_t queue = 64 << 10;  // bytes waiting for the rate limit; beyond that they are lost
  std::size_t mtu = 0;             // larger datagrams are dropped; 0: none are
  bool blackout = false;           // all are dropped

  bool operator==(const Faults&) const = default;
};

class FaultInjector {
 public:
  explicit FaultInjector(std::uint64_t seed) : state_(seed) {}

  void set(const Faults& faults) { faults_ = faults; }
  [[nodiscard]] const Faults& faults() const { return faults_; }

  // Arrival times, one for each copy; `count` 0: the datagram is lost.
  struct Copies {
    std::size_t count = 0;
    std::array<Time, 2> at{};
  };
  Copies send(Time now, std::size_t size);

 private:
  double random();  // uniform in [0, 1)
  Time arrival(Time sent);

  Faults faults_{};
  std::uint64_t state_;
  Time line_free_{};  // when the rate limit admits the next datagram
  Time last_{};       // the last arrival in order
};

}  // namespace tims::link
