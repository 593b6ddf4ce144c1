// Memory of incomplete work: messages waiting for slow readers (WaitingMemory), and messages
// received in part (HalfMessages).
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

// A bound on the memory of incomplete messages, over all clients of a port. When it is exceeded,
// one client is disconnected: of those that hold at least an equal share, the one without
// progress for the longest time. Pure.
class HalfMessages {
 public:
  // The amount a client may hold regardless of the bound; also the step that counts as progress.
  static constexpr std::uint64_t kStepBytes = 64 << 10;

  explicit HalfMessages(std::uint32_t message_max)
      : bytes_max_(std::max<std::uint64_t>(64U << 20, std::uint64_t{2} * message_max)) {}

  // The amount held by client `token` now, after a change in either direction.
  void set(Time now, std::uint32_t token, std::uint64_t bytes);
  // The client to disconnect: close its connection and call set() with 0. Empty while within
  // bounds.
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
    Time since{};             // time of its last progress
  };

  std::uint64_t bytes_max_;
  std::uint64_t bytes_ = 0;
  std::vector<Holder> holders_;  // clients that hold more than one step
};

// Memory for waiting messages: reserved once, physical memory is used only where touched.
class WaitingMemory {
 public:
  // Smaller when the system does not provide as much.
  explicit WaitingMemory(std::size_t bytes);
  WaitingMemory(const WaitingMemory&) = delete;
  WaitingMemory& operator=(const WaitingMemory&) = delete;
  ~WaitingMemory();

  core::BlockPool& pool() { return pool_; }
  [[nodiscard]] std::span<std::byte> bytes() const { return memory_; }

  // Returns the bytes to the system; their contents are lost.
  static void discard(std::span<std::byte> bytes);

  // Called after every turn: once no messages wait, returns the memory to the system.
  void give_back();

 private:
  std::span<std::byte> memory_;
  core::BlockPool pool_;
};

}  // namespace tims::io
