// Memory of messages that are not done: those that wait for slow readers (WaitingMemory), and those
// that have begun to come and are not complete (HalfMessages).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "router/core/byte_chain.h"
#include "tims/time.h"

namespace tims::io {

// Memory for messages that have begun to come and are not complete, over all clients of a port:
// bounded. When it is used up, somebody's has to go: of those who hold at least their equal share,
// the one who has longest not sent on. Pure.
class HalfMessages {
 public:
  // What a client may hold beside all bounds; and so much is progress.
  static constexpr std::uint64_t kStepBytes = 64 << 10;

  explicit HalfMessages(std::uint32_t message_max)
      : bytes_max_(std::max<std::uint64_t>(64U << 20, std::uint64_t{2} * message_max)) {}

  // What the client `token` holds now, before or after more has come.
  void set(Time now, std::uint32_t token, std::uint64_t bytes);
  // Who has to go: its connection is closed, and set() to 0. Nothing while all is within bounds.
  struct Victim {
    std::uint32_t token = 0;
    std::uint64_t bytes = 0;
  };
  [[nodiscard]] std::optional<Victim> victim() const;

  [[nodiscard]] std::uint64_t bytes_max() const { return bytes_max_; }

 private:
  struct Holder {
    std::uint32_t token = 0;
    std::uint64_t bytes = 0;
    std::uint64_t noted = 0;  // bytes at `since`
    Time since{};             // of its last progress
  };

  std::uint64_t bytes_max_;
  std::uint64_t bytes_ = 0;
  std::vector<Holder> holders_;  // of more than a step
};

// Memory for messages that wait: reserved once, used by the system only as far as it is touched.
class WaitingMemory {
 public:
  // Less when the system does not give as much.
  explicit WaitingMemory(std::size_t bytes);
  WaitingMemory(const WaitingMemory&) = delete;
  WaitingMemory& operator=(const WaitingMemory&) = delete;
  ~WaitingMemory();

  core::BlockPool& pool() { return pool_; }
  [[nodiscard]] std::span<std::byte> bytes() const { return memory_; }

  // Bytes of such memory go back to the system; what they held is gone.
  static void discard(std::span<std::byte> bytes);

  // After every turn: once nothing waits any more, what it took goes back to the system.
  void give_back();

 private:
  std::span<std::byte> memory_;
  core::BlockPool pool_;
};

}  // namespace tims::io
