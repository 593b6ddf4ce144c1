// Memory of the lanes: bytes between two offsets, waiting or in flight (StreamBuffer), their age
// (AgeMarks), sets of ranges (RangeSet), the fate of sent bytes (SentRanges), and messages
// received in parts (MessageMemory).
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <iterator>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "router/core/byte_chain.h"
#include "router/policy/lifetimes.h"
#include "tims/message.h"
#include "tims/time.h"

namespace tims::link {

// A half-open range of byte offsets. RangeSet: a small, sorted set of disjoint ranges.
struct Range {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;

  [[nodiscard]] std::uint64_t size() const { return end - begin; }
  bool operator==(const Range&) const = default;
};

class RangeSet {
 public:
  static constexpr std::size_t kRangesMax = 512;

  // Returns false, with nothing added, when there would be more than kRangesMax ranges.
  bool add(Range range);
  void remove(Range range);
  // Removes everything below `offset`.
  void remove_below(std::uint64_t offset);
  void clear() { ranges_.clear(); }

  [[nodiscard]] bool empty() const { return ranges_.empty(); }
  [[nodiscard]] const std::vector<Range>& ranges() const { return ranges_; }
  [[nodiscard]] Range front() const { return ranges_.front(); }
  [[nodiscard]] bool contains(Range range) const;
  // The first part of `range` that is not in the set.
  [[nodiscard]] std::optional<Range> first_missing(Range range) const;

 private:
  [[nodiscard]] std::size_t first_ending_at_or_after(std::uint64_t offset) const;

  std::vector<Range> ranges_;
};

// The fate of bytes that were sent and are still stored: which were acknowledged, and which must
// be sent again.
class SentRanges {
 public:
  // Returns false when the set is full and the acknowledgement was not recorded. These bytes are
  // sent once more; the receiver ignores them.
  bool on_acked(Range range) {
    if (repeats()) lost_.remove(range);
    if (acked_.add(range)) return true;
    on_lost(range);
    return false;
  }
  void on_lost(Range range);
  void on_sent_again(Range range) { lost_.remove(range); }
  // The bytes are no longer stored.
  void forget(Range range) {
    if (!acked_.empty()) acked_.remove(range);
    if (repeats()) lost_.remove(range);
  }
  void forget_below(std::uint64_t offset) {
    acked_.remove_below(offset);
    if (repeats()) lost_.remove_below(offset);
  }
  void clear();

  [[nodiscard]] const RangeSet& acked() const { return acked_; }
  [[nodiscard]] bool repeats() const { return !lost_.empty(); }
  [[nodiscard]] Range first_lost() const { return lost_.front(); }

 private:
  RangeSet acked_;
  RangeSet lost_;
};

// The age of bytes in a queue, to within some milliseconds: marks at the beginnings of messages,
// few enough to cost nothing.
class AgeMarks {
 public:
  // Bytes were appended at `offset`.
  void add(std::uint64_t offset, Time now) {
    if (!marks_.empty() && now < marks_.back().at + kResolution) return;
    marks_.push_back({offset, now});
  }
  // The result is the beginning of a message; everything below it was appended before `limit`.
  [[nodiscard]] std::uint64_t older_than(Time limit, std::uint64_t end) const {
    for (const Mark& mark : marks_) {
      if (mark.at + kResolution > limit) return mark.offset;
    }
    return end;
  }
  // Time at which the bytes at the front were appended; `offset` is the front.
  [[nodiscard]] Time oldest(std::uint64_t offset) {
    forget_below(offset);
    return marks_.empty() ? kNever : marks_.front().at;
  }
  // Bytes below have the time of oldest().
  [[nodiscard]] std::uint64_t oldest_end() const {
    return marks_.size() > 1 ? marks_[1].offset : UINT64_MAX;
  }
  // Time at which the bytes at `offset` were appended; there are some.
  [[nodiscard]] Time at(std::uint64_t offset) const {
    const auto later = std::ranges::upper_bound(marks_, offset, {}, &Mark::offset);
    return later == marks_.begin() ? marks_.front().at : std::prev(later)->at;
  }
  void forget_below(std::uint64_t offset) {
    while (marks_.size() > 1 && marks_[1].offset <= offset) marks_.pop_front();
  }
  void clear() { marks_.clear(); }

 private:
  static constexpr Duration kResolution = std::chrono::milliseconds(10);
  struct Mark {
    std::uint64_t offset;
    Time at;
  };
  std::deque<Mark> marks_;
};

// When the messages of a stream that have a lifetime are too old, by their offsets.
class Deadlines {
 public:
  void add(std::uint64_t offset, Time at) { deadlines_.push_back({offset, at}); }
  void forget_below(std::uint64_t offset) {
    while (first_ < deadlines_.size() && deadlines_[first_].offset < offset) ++first_;
    if (first_ * 2 < deadlines_.size()) return;
    deadlines_.erase(deadlines_.begin(), deadlines_.begin() + static_cast<std::ptrdiff_t>(first_));
    first_ = 0;
  }
  // Those of messages that begin in the range and whose time has passed; each is visited once.
  template <typename Visit>  // (offset)
  void take_passed(Time now, Range range, Visit visit) {
    const auto begin = deadlines_.begin() + static_cast<std::ptrdiff_t>(first_);
    auto at = std::ranges::lower_bound(begin, deadlines_.end(), range.begin, {}, &Deadline::offset);
    for (; at != deadlines_.end() && at->offset < range.end; ++at) {
      if (now <= at->at) continue;
      at->at = kNever;
      visit(at->offset);
    }
  }
  void clear() {
    deadlines_.clear();
    first_ = 0;
  }

 private:
  struct Deadline {
    std::uint64_t offset;
    Time at;
  };
  std::vector<Deadline> deadlines_;  // keeps its memory
  std::size_t first_ = 0;            // the ones before are forgotten
};

// Bytes of a lane between two offsets: appended at the end, released at the front, read anywhere.
// They are stored in blocks of a shared pool; a ring of block numbers finds each block in
// constant time.
class StreamBuffer {
 public:
  explicit StreamBuffer(core::BlockPool& pool) : pool_(pool) {}
  StreamBuffer(const StreamBuffer&) = delete;
  StreamBuffer& operator=(const StreamBuffer&) = delete;
  ~StreamBuffer() { release_to(end_); }

  [[nodiscard]] std::uint64_t begin() const { return begin_; }
  [[nodiscard]] std::uint64_t end() const { return end_; }
  [[nodiscard]] std::uint64_t size() const { return end_ - begin_; }
  [[nodiscard]] bool empty() const { return begin_ == end_; }

  // True when the pool has enough blocks to append as much.
  [[nodiscard]] bool has_room(std::size_t size) const;
  void append(std::span<const std::byte> bytes) {  // precondition: has_room()
    while (!bytes.empty()) {
      if (end_ == base_ + count_ * kBlock) add_block();
      const std::size_t size = std::min(left_in_block(end_), bytes.size());
      std::memcpy(at(end_), bytes.data(), size);
      slot(count_ - 1).needed += static_cast<std::uint32_t>(size);
      end_ += size;
      bytes = bytes.subspan(size);
    }
  }

  // Copies the bytes from `offset` on. Precondition: all of them are stored.
  void read(std::uint64_t offset, std::span<std::byte> to) const {
    while (!to.empty()) {
      const std::size_t size = std::min(left_in_block(offset), to.size());
      std::memcpy(to.data(), at(offset), size);
      offset += size;
      to = to.subspan(size);
    }
  }
  // Overwrites the bytes from `offset` on. Precondition: all of them are stored.
  void write(std::uint64_t offset, std::span<const std::byte> bytes);
  // Moves the first `size` bytes to the end of another buffer. Precondition: it has room.
  void move_front(std::size_t size, StreamBuffer& to);

  void release_to(std::uint64_t offset);
  // Alternative to release(): frees bytes anywhere, each once; a block whose bytes are all freed
  // is returned.
  void free(Range range);
  // Empties the buffer; the next byte has this offset.
  void reset(std::uint64_t offset);

 private:
  static constexpr std::size_t kBlock = core::BlockPool::kBlockSize;

  struct Block {
    core::BlockPool::Index index = core::BlockPool::kNone;  // kNone: all of it was freed
    std::uint32_t needed = 0;                               // bytes not yet freed
  };
  [[nodiscard]] std::byte* at(std::uint64_t offset) const {
    const std::uint64_t i = (offset - base_) / kBlock;
    return pool_.at(ring_[(first_ + i) & (ring_.size() - 1)].index) + (offset - base_) % kBlock;
  }
  [[nodiscard]] std::size_t left_in_block(std::uint64_t offset) const {
    return kBlock - static_cast<std::size_t>((offset - base_) % kBlock);
  }
  [[nodiscard]] Block& slot(std::uint64_t i) { return ring_[(first_ + i) & (ring_.size() - 1)]; }
  void add_block();
  void give_back(Block& block) {
    if (block.index != core::BlockPool::kNone) pool_.release(block.index);
    block.index = core::BlockPool::kNone;
  }

  core::BlockPool& pool_;
  std::vector<Block> ring_;  // a power of two, or empty
  std::size_t first_ = 0;    // index of the first block in ring_
  std::size_t count_ = 0;
  std::uint64_t base_ = 0;  // offset of the first byte of the first block
  std::uint64_t begin_ = 0;
  std::uint64_t end_ = 0;
};

// Memory for messages received in parts, shared by all links of a router.
//
// Each message has a place for the largest message: address space reserved by the caller.
// Physical memory is taken as its bytes arrive, one chunk at a time, and all messages together
// take at most `bytes_max`. So received bytes are copied once, and an announced length alone
// costs nothing.
//
// Incomplete messages could block each other forever, each waiting for memory the others hold.
// Therefore memory for one message of maximum size is reserved: the first message that finds no
// other memory has it until it is complete or given up. It can always progress, whatever the
// others hold, and after it the next one.
class MessageMemory {
 public:
  static constexpr std::size_t kChunk = 16 << 10;
  static constexpr std::size_t kPlacesMax = 1024;
  static constexpr std::size_t kPlacesMin = 16;

  // `address_space`: untouched and page-aligned.
  MessageMemory(std::span<std::byte> address_space, std::uint32_t message_max,
                std::size_t bytes_max);
  MessageMemory(const MessageMemory&) = delete;
  MessageMemory& operator=(const MessageMemory&) = delete;

  // True when there are enough places, and memory in addition to the reserve.
  [[nodiscard]] bool is_enough() const {
    return touched_.size() >= kPlacesMin && bytes_max_ >= 2 * place_bytes_;
  }
  [[nodiscard]] static std::size_t place_bytes(std::uint32_t message_max) {
    return whole_chunks(message_max);
  }
  [[nodiscard]] static std::size_t whole_chunks(std::size_t size) {
    return (size + kChunk - 1) / kChunk * kChunk;
  }

  [[nodiscard]] std::size_t place_size() const { return place_bytes_; }
  [[nodiscard]] std::size_t bytes_max() const { return bytes_max_; }
  [[nodiscard]] std::size_t used_bytes() const { return used_ + kept_used_; }
  [[nodiscard]] std::size_t free_bytes() const { return bytes_max_ - place_bytes_ - used_; }
  // The amount one link may have while another needs some: as much as it leaves, or an equal
  // share.
  [[nodiscard]] std::size_t share() const {
    return std::max(free_bytes(), (bytes_max_ - place_bytes_) / (users_ + 1));
  }
  void add_user() { ++users_; }  // a link that uses some of the memory
  void remove_user() { --users_; }
  [[nodiscard]] std::size_t free_places() const { return free_.size(); }

  // Part of a free, previously used place, whose memory should be returned to the system; empty
  // when there is no more. The caller returns it after every turn.
  [[nodiscard]] std::span<std::byte> surplus();

  // A link's request failed: the others must give back what they hold without need. Not the
  // requesting link itself, whose lanes wait for each other.
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
  // Grows from `size` to `larger` bytes, both whole chunks.
  [[nodiscard]] bool grow(std::uint32_t place, std::size_t size, std::size_t larger);
  [[nodiscard]] bool grow_as_kept(std::uint32_t place, std::size_t size, std::size_t larger);
  void touch(std::uint32_t place, std::size_t size);
  void release(std::uint32_t place, std::size_t size);
  [[nodiscard]] std::byte* at(std::uint32_t place) const { return memory_ + place * place_bytes_; }

  std::byte* memory_;
  std::size_t place_bytes_;
  std::size_t bytes_max_;
  std::size_t used_ = 0;              // without the message that has the reserve
  std::size_t kept_used_ = 0;         // by the message that has the reserve
  std::uint32_t has_kept_ = kNone;    // place of that message
  std::vector<std::size_t> touched_;  // by place: bytes the system may have committed
  std::size_t touched_bytes_ = 0;     // sum over all places
  std::vector<std::uint32_t> free_;   // most recently used places are reused first
  std::size_t users_ = 0;
  struct Wanted {
    const void* link = nullptr;
    Time at{};
  };
  std::array<Wanted, 2> wanted_by_{};  // the last two links
};

// A place and the memory taken for it; both are returned by the destructor.
class MessageBuffer {
 public:
  MessageBuffer() = default;
  // Empty when there is no place. No memory is taken yet.
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
  // Grows to `size` bytes, rounded up to a chunk, at most one place. Returns false when there is
  // no memory now.
  bool grow(std::size_t size) {
    const std::size_t larger = MessageMemory::whole_chunks(size);
    if (larger <= size_) return true;
    if (!memory_->grow(place_, size_, larger)) return false;
    size_ = larger;
    return true;
  }
  // As grow(), using the reserve, for a message that would otherwise wait for memory.
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

// Reassembly memory shared by the lanes of one link, and the link's share of the memory of all
// links. While another link needs memory, a link takes no more than it leaves to others (a
// dynamic threshold: Choudhury, Hahne 1998) or an equal share, except for the one message that
// has the reserve (MessageMemory). Places and blocks are always shared in this way.
struct Reassembly {
  core::BlockPool& pool;             // for bytes that arrive out of order
  MessageMemory& memory;             // for messages received in parts
  std::vector<MessageBuffer>& done;  // messages handed on and still being read
  std::uint32_t message_max = kMessageMaxDefault;
  const policy::Lifetimes* lifetimes = nullptr;  // null: no message has one
  std::size_t blocks = 0;                        // blocks of the pool used by this link
  std::size_t bytes = 0;                         // bytes of the memory used by this link
  std::size_t places = 0;                        // places of the memory used by this link

  core::BlockPool::Index take_block();
  void give_block(core::BlockPool::Index& block);
  // Grows `buffer`, which is empty before its first bytes arrive, to `size`. Returns false when
  // that is not possible now. With `will_retry` the bytes will be sent again, and the reserve may
  // be used.
  bool grow(Time now, MessageBuffer& buffer, std::size_t size, bool will_retry);
  void give(MessageBuffer& buffer);
  void hand_on(MessageBuffer& buffer);  // the message is read until the turn ends
  void forget(const MessageBuffer& buffer);
  [[nodiscard]] bool is_used() const { return places > 0; }
  // True when so many bytes are more than the link may have now.
  [[nodiscard]] bool is_over_share(Time now, std::size_t of_bytes) const {
    return memory.is_wanted(now, this) && of_bytes > memory.share();
  }
};

}  // namespace tims::link
