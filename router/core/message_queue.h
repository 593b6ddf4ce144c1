// Messages that wait for a slow receiver: whole ones, the most important first, then by arrival,
// within a bound.
//
// Full: the oldest message of the lowest priority here goes, if its priority is not higher than
// the new one's, and so on until the new one fits; otherwise the new one is refused. A message of
// which bytes have already been written is never removed and never overtaken.
//
// Every priority is a stream of bytes in blocks of a shared pool: messages leave each only at the
// front, to be written or to be dropped, so nothing else must be kept of them and small ones lie
// side by side. The index of the 256 priorities is itself a block, taken with the first message.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "router/core/byte_chain.h"
#include "router/core/statistics.h"
#include "router/core/types.h"
#include "tims/message.h"

namespace tims::core {

class MessageQueue {
 public:
  // kFair: beside its bound, the queue takes at most half of what the pool has left (a dynamic
  // threshold). However many receivers are stalled, there is room for the next one.
  enum class Share : std::uint8_t { kAll, kFair };
  // `classes`: what is lost is counted by, by header; they live as long as the queue.
  MessageQueue(BlockPool& pool, std::uint64_t bytes_max, Share share = Share::kAll,
               const PriorityClasses& classes = kConventionalClasses)
      : pool_(pool), classes_(classes), bytes_max_(bytes_max), share_(share) {}
  MessageQueue(const MessageQueue&) = delete;
  MessageQueue& operator=(const MessageQueue&) = delete;
  ~MessageQueue();

  // A lower bound takes effect with the next push.
  void set_bytes_max(std::uint64_t bytes_max) { bytes_max_ = bytes_max; }

  // `message`: a whole one, its header in the machine's own order. False: refused. What had to go
  // for it is added to `replaced`.
  bool push(std::span<const std::byte> message, std::uint8_t priority, LossCounts& replaced);

  // The rest of a message whose beginning was written past this queue, which is empty. False when
  // the pool has no memory for it: then the receiver cannot be served any more.
  bool push_rest(std::span<const std::byte> rest, const Header& header);

  // What is to be written next, in order; returns how many pieces there are.
  std::size_t gather(std::span<std::span<const std::byte>> pieces) const;
  // The first `size` bytes of that were written.
  void consume(std::uint64_t size);

  // Throws everything away.
  void clear(LossCounts& lost);

  [[nodiscard]] bool empty() const { return bytes_ == 0; }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  struct Level {
    ByteChain messages;
    std::uint32_t bytes = 0;
    std::uint32_t count = 0;
  };
  static constexpr std::size_t kLevels = 256;
  static_assert(sizeof(Level) * kLevels == BlockPool::kBlockSize);
  static constexpr std::size_t kNoLevel = kLevels;

  bool open();
  void close();
  [[nodiscard]] std::uint64_t limit() const;
  [[nodiscard]] bool make_room(std::size_t size, std::uint8_t priority, LossCounts& replaced);
  [[nodiscard]] bool fits(std::size_t size, std::uint8_t priority) const;
  [[nodiscard]] std::uint64_t bytes_up_to(std::uint8_t priority) const;
  void drop_oldest(std::size_t level, LossCounts& replaced);
  std::uint64_t consume_begun(std::uint64_t size);
  std::uint64_t consume_first(std::uint64_t size);
  [[nodiscard]] Header header_of_first(const Level& level) const;
  void took(std::size_t i, std::uint32_t length);

  [[nodiscard]] Level* levels() const { return reinterpret_cast<Level*>(pool_.at(index_)); }
  [[nodiscard]] std::size_t lowest() const;   // kNoLevel when there is none
  [[nodiscard]] std::size_t highest() const;  // kNoLevel when there is none

  BlockPool& pool_;
  const PriorityClasses& classes_;
  std::uint64_t bytes_max_;
  Share share_;
  std::uint64_t bytes_ = 0;  // in begun_ and all levels
  ByteChain begun_;          // the rest of a message that has been written in part
  std::uint64_t begun_bytes_ = 0;
  std::size_t begun_class_ = 0;
  BlockPool::Index index_ = BlockPool::kNone;       // block of the levels, while there are some
  BlockPool::Index spare_ = BlockPool::kNone;       // so that a message can always become begun_
  std::array<std::uint64_t, kLevels / 64> used_{};  // bit: this level has messages
};

}  // namespace tims::core
