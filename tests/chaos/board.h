// Counters of the messages that every client of a chaos run has sent to and received from every
// other one, in a file mapped by all processes, so that they survive kill -9.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "tests/bench/shared_file.h"
#include "tims/address.h"

namespace tims::chaos {

inline constexpr std::size_t kClientsMax = 32;
// The priority of each flow; messages of one flow arrive in order. The flows are one per class
// except texts, two of the highest class, and samples.
inline constexpr std::array<std::uint8_t, 9> kPriorities{150, 0, 1, 20, 30, 40, 50, 255, 60};
inline constexpr std::size_t kFlows = kPriorities.size();
inline constexpr std::size_t kSamples = kFlows - 1;

enum class Phase : std::uint32_t {
  kQuiet,
  kTraffic,  // messages of all kinds to random clients
  kTour,     // a short one to each client in turn
};

// Counters of one flow from one client to another.
struct Cell {
  // Written by the sender.
  std::atomic<std::uint32_t> sent;      // number of the last message
  std::atomic<std::uint32_t> refused;   // those that send() refused
  std::atomic<std::uint32_t> answered;  // NOT_AVAILABLE
  // Written by the receiver.
  std::atomic<std::uint32_t> received;
  std::atomic<std::uint32_t> newest;  // highest number received
  std::atomic<std::uint64_t> seen;    // bit n: message newest - n was received

  // Messages in transit or lost.
  [[nodiscard]] std::uint32_t missing() const { return sent - refused - received; }
};

struct Board {
  std::atomic<Phase> phase;
  std::atomic<std::uint32_t> wrong;        // lines "WRONG" in the logs of clients
  std::atomic<std::uint32_t> standstills;  // times that a client was not scheduled for too long
  std::uint32_t clients;
  std::array<std::uint32_t, kClientsMax> addresses;
  std::array<std::array<std::array<Cell, kFlows>, kClientsMax>, kClientsMax> cells;  // [from][to]

  [[nodiscard]] Address address(std::size_t client) const { return Address(addresses[client]); }
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);  // between processes

class SharedBoard {
 public:
  static Result<SharedBoard> at(const std::string& path);
  Board* operator->() const { return reinterpret_cast<Board*>(memory_.get()); }
  Board& operator*() const { return *operator->(); }

 private:
  explicit SharedBoard(bench::SharedFile memory) : memory_(std::move(memory)) {}
  bench::SharedFile memory_;
};

}  // namespace tims::chaos
