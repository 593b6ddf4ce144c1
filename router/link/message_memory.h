// Memory for messages that come in parts: contiguous pieces of a region that the caller has
// reserved, by the buddy method (Knowlton 1965): sizes are powers of two, a free piece is split in
// halves, and two free halves become one again.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "tims/time.h"

namespace tims::link {

class MessageMemory {
 public:
  static constexpr std::size_t kPieceMin = 4096;

  // Uses the largest power of two of kPieceMin that fits.
  explicit MessageMemory(std::span<std::byte> memory);
  MessageMemory(const MessageMemory&) = delete;
  MessageMemory& operator=(const MessageMemory&) = delete;

  // Empty when there is none. Its content is whatever it was.
  [[nodiscard]] std::span<std::byte> allocate(std::size_t size);
  void release(std::span<std::byte> bytes);  // from allocate()

  [[nodiscard]] std::size_t used_bytes() const { return used_; }
  [[nodiscard]] std::size_t size() const { return pieces_.size() * kPieceMin; }
  [[nodiscard]] bool has_room_for(std::size_t message) const {
    return std::bit_ceil(message) <= size() / 2;
  }

  // A link has asked in vain: the others give back what they hold without need. Not itself, whose
  // lanes wait for each other.
  void note_wanted(Time now, const void* link) {
    if (link != wanted_by_[0].link) wanted_by_[1] = wanted_by_[0];
    wanted_by_[0] = {link, now};
  }
  [[nodiscard]] bool is_wanted(Time now, const void* link) const {
    return std::ranges::any_of(wanted_by_, [&](const Wanted& wanted) {
      return wanted.link != nullptr && wanted.link != link &&
             now < wanted.at + std::chrono::seconds(5);
    });
  }

 private:
  static constexpr std::size_t kOrders = 21;
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;
  // Of a piece, kept at the number of its first kPieceMin bytes.
  struct Piece {
    std::uint32_t next = kNone;
    std::uint32_t previous = kNone;
    std::uint8_t order = 0;
    bool free = false;
  };

  void push(std::uint32_t piece, std::size_t order);
  void unlink(std::uint32_t piece);

  std::byte* memory_;
  std::size_t order_max_ = 0;
  std::vector<Piece> pieces_;
  std::array<std::uint32_t, kOrders> free_;  // first free piece of each order
  std::size_t used_ = 0;
  struct Wanted {
    const void* link = nullptr;
    Time at{};
  };
  std::array<Wanted, 2> wanted_by_{};  // the last two links
};

// A piece that goes back by itself.
class MessageBuffer {
 public:
  MessageBuffer() = default;
  MessageBuffer(MessageMemory& memory, std::size_t size)
      : memory_(&memory), bytes_(memory.allocate(size)) {}
  MessageBuffer(MessageBuffer&& other) noexcept
      : memory_(other.memory_), bytes_(std::exchange(other.bytes_, {})) {}
  MessageBuffer& operator=(MessageBuffer&& other) noexcept {
    reset();
    memory_ = other.memory_;
    bytes_ = std::exchange(other.bytes_, {});
    return *this;
  }
  ~MessageBuffer() { reset(); }

  explicit operator bool() const { return !bytes_.empty(); }
  [[nodiscard]] std::span<std::byte> bytes() const { return bytes_; }
  void reset() {
    if (!bytes_.empty()) memory_->release(std::exchange(bytes_, {}));
  }

 private:
  MessageMemory* memory_ = nullptr;
  std::span<std::byte> bytes_;
};

}  // namespace tims::link
