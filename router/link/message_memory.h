// Memory for messages that come in parts, of all links of a router.
//
// A message has a place for the largest one: address space that the caller has reserved. It takes
// memory as its bytes come, a chunk at a time, and all together take no more than `bytes_max`. So
// what comes is copied once, and what is only announced costs nothing.
//
// Messages that are half here could wait for each other's memory for ever. Therefore as much as the
// largest message needs is kept: the first that finds no other memory has it until it is complete
// or given up. It can always go on, whatever the others hold, and after it the next one.
#pragma once

#include <algorithm>
#include <array>
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
  static constexpr std::size_t kChunk = 16 << 10;
  static constexpr std::size_t kPlacesMax = 1024;
  static constexpr std::size_t kPlacesMin = 16;

  // `address_space`: untouched, at the beginning of a page.
  MessageMemory(std::span<std::byte> address_space, std::uint32_t message_max,
                std::size_t bytes_max);
  MessageMemory(const MessageMemory&) = delete;
  MessageMemory& operator=(const MessageMemory&) = delete;

  // Enough places, and memory for others beside what is kept.
  [[nodiscard]] bool is_enough() const {
    return touched_.size() >= kPlacesMin && bytes_max_ >= 2 * place_bytes_;
  }
  [[nodiscard]] static std::size_t place_bytes(std::uint32_t message_max) {
    return whole_chunks(message_max);
  }
  [[nodiscard]] static std::size_t whole_chunks(std::size_t size) {
    return (size + kChunk - 1) / kChunk * kChunk;
  }

  [[nodiscard]] std::size_t bytes_max() const { return bytes_max_; }
  [[nodiscard]] std::size_t used_bytes() const { return used_ + kept_used_; }
  [[nodiscard]] std::size_t free_bytes() const { return bytes_max_ - place_bytes_ - used_; }
  // What one link may have while another wants some: as much as it leaves, or an equal share.
  [[nodiscard]] std::size_t share() const {
    return std::max(free_bytes(), (bytes_max_ - place_bytes_) / (users_ + 1));
  }
  void add_user() { ++users_; }  // a link that has some
  void remove_user() { --users_; }
  [[nodiscard]] std::size_t free_places() const { return free_.size(); }

  // A part of a free place that was used before, and whose memory should go back to the system;
  // empty when there is no more. The caller does it, after every turn.
  [[nodiscard]] std::span<std::byte> surplus();

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
  friend class MessageBuffer;
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;
  static constexpr std::size_t kTouchedIfIdle = 32 << 20;

  [[nodiscard]] std::uint32_t take_place();
  // From `size` to `larger` bytes, both in whole chunks.
  [[nodiscard]] bool grow(std::uint32_t place, std::size_t size, std::size_t larger);
  [[nodiscard]] bool grow_as_kept(std::uint32_t place, std::size_t size, std::size_t larger);
  void touch(std::uint32_t place, std::size_t size);
  void release(std::uint32_t place, std::size_t size);
  [[nodiscard]] std::byte* at(std::uint32_t place) const { return memory_ + place * place_bytes_; }

  std::byte* memory_;
  std::size_t place_bytes_;
  std::size_t bytes_max_;
  std::size_t used_ = 0;              // but for the message that has what is kept
  std::size_t kept_used_ = 0;         // by that one
  std::uint32_t has_kept_ = kNone;    // its place
  std::vector<std::size_t> touched_;  // by place: bytes that the system may have given
  std::size_t touched_bytes_ = 0;     // of all
  std::vector<std::uint32_t> free_;   // the place used last is used again first
  std::size_t users_ = 0;
  struct Wanted {
    const void* link = nullptr;
    Time at{};
  };
  std::array<Wanted, 2> wanted_by_{};  // the last two links
};

// A place, and the memory that was taken for it; goes back by itself.
class MessageBuffer {
 public:
  MessageBuffer() = default;
  // Empty when there is no place. It has no bytes yet.
  explicit MessageBuffer(MessageMemory& memory) : memory_(&memory), place_(memory.take_place()) {}
  MessageBuffer(MessageBuffer&& other) noexcept { *this = std::move(other); }
  MessageBuffer& operator=(MessageBuffer&& other) noexcept {
    reset();
    memory_ = other.memory_;
    place_ = std::exchange(other.place_, MessageMemory::kNone);
    size_ = std::exchange(other.size_, 0);
    return *this;
  }
  ~MessageBuffer() { reset(); }

  explicit operator bool() const { return place_ != MessageMemory::kNone; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::span<std::byte> bytes() const {
    return *this ? std::span(memory_->at(place_), size_) : std::span<std::byte>();
  }
  // To `size` bytes and the rest of the chunk, at most a place. False: there are none now.
  bool grow(std::size_t size) {
    const std::size_t larger = MessageMemory::whole_chunks(size);
    if (larger <= size_) return true;
    if (!memory_->grow(place_, size_, larger)) return false;
    size_ = larger;
    return true;
  }
  // The same with what is kept, for a message that will wait for it.
  bool grow_as_kept(std::size_t size) {
    const std::size_t larger = MessageMemory::whole_chunks(size);
    if (!memory_->grow_as_kept(place_, size_, larger)) return false;
    size_ = larger;
    return true;
  }
  void reset() {
    if (*this) memory_->release(std::exchange(place_, MessageMemory::kNone), size_);
    size_ = 0;
  }

 private:
  MessageMemory* memory_ = nullptr;
  std::uint32_t place_ = MessageMemory::kNone;
  std::size_t size_ = 0;
};

}  // namespace tims::link
