// A bad network, made on purpose: what becomes of each datagram, from a seed. The simulator's
// network consists of these; the real socket sends through one when it is told to
// (`timsctl sim fault`).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "tims/time.h"

namespace tims::link {

struct Faults {
  double loss = 0;  // share of the datagrams, 0 to 1
  double duplicate = 0;
  double reorder = 0;  // of those that are held back
  Duration held_back = std::chrono::milliseconds(5);
  Duration delay{};
  Duration jitter{};               // up to so much more, without changing the order
  std::uint64_t rate = 0;          // bytes a second; 0: no limit
  std::uint64_t queue = 64 << 10;  // bytes that wait for the rate; beyond that they are lost
  std::size_t mtu = 0;             // larger datagrams vanish; 0: none do
  bool blackout = false;           // all vanish

  bool operator==(const Faults&) const = default;
};

class FaultInjector {
 public:
  explicit FaultInjector(std::uint64_t seed) : state_(seed) {}

  void set(const Faults& faults) { faults_ = faults; }
  [[nodiscard]] const Faults& faults() const { return faults_; }

  // When the datagram arrives, once for each copy; `count` 0: it is lost.
  struct Copies {
    std::size_t count = 0;
    std::array<Time, 2> at{};
  };
  Copies send(Time now, std::size_t size);

 private:
  double random();  // from 0 to below 1
  Time arrival(Time sent);

  Faults faults_{};
  std::uint64_t state_;
  Time line_free_{};  // the rate lets the next one go
  Time last_{};       // the last ordinary arrival
};

}  // namespace tims::link
