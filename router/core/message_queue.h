// Messages waiting for a slow receiver: whole messages, by priority, then by arrival, within a
// size limit.
//
// When the queue is full, the oldest message of the lowest priority is dropped if its priority is
// not higher than the new one's, repeatedly until the new message fits; otherwise the new message
// is refused. A message that is already partly written is never removed or overtaken.
//
// Each priority is a stream of bytes in blocks of a shared pool: messages leave it only at the
// front, to be written or dropped, so no other bookkeeping is needed and small messages are
// contiguous. The index of the 256 priorities is itself a block, allocated with the first
// message.
//
// For a receiver that keeps the newest only (keep_newest()), a sample takes the place of a waiting
// one of the same stream: same source, destination, type and priority. It keeps the turn of the
// older one, so that a fast stream does not wait behind slower ones for ever.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "router/core/byte_chain.h"
#include "router/core/queue_shares.h"
#include "router/core/statistics.h"
#include "router/core/stream_counters.h"
#include "router/core/types.h"
#include "tims/message.h"

namespace tims::core {

class MessageQueue {
 public:
  // `classes`: lost messages are counted by class; must outlive the queue.
  MessageQueue(BlockPool& pool, std::uint64_t bytes_max,
               const PriorityClasses& classes = kConventionalClasses)
      : pool_(pool), classes_(classes), bytes_max_(bytes_max) {}
  // In addition to its own limit, the queue takes at most half of the free space of the pool (a
  // dynamic threshold). However many receivers are stalled, there is room for the next one; and
  // for one that reads, the stalled ones make room.
  MessageQueue(QueueShares& shares, QueueOwner& owner, std::uint64_t bytes_max,
               const PriorityClasses& classes = kConventionalClasses)
      : pool_(shares.pool()),
        classes_(classes),
        bytes_max_(bytes_max),
        shares_(&shares),
        owner_(&owner) {}
  MessageQueue(const MessageQueue&) = delete;
  MessageQueue& operator=(const MessageQueue&) = delete;
  ~MessageQueue();

  // A lower bound takes effect with the next push.
  void set_bytes_max(std::uint64_t bytes_max) { bytes_max_ = bytes_max; }

  // From now on, of each stream only the newest sample waits. `counters` counts those that are
  // dropped, and must outlive the queue.
  void keep_newest(StreamCounters& counters) { streams_ = &counters; }

  // `message`: a whole message, its header in host byte order. Returns false when refused.
  // Messages dropped to make room are added to `replaced`.
  bool push(std::span<const std::byte> message, std::uint8_t priority, LossCounts& replaced);

  // True: the rest of `size` bytes of messages can be kept, however little of them is written
  // directly. Others may have to give their memory for it. Precondition: the queue is empty.
  bool reserve(std::size_t size);

  // The rest of a message whose beginning was written directly, while this queue was empty.
  // Returns false when the pool has no memory for it: then the receiver cannot be served any
  // more.
  bool push_rest(std::span<const std::byte> rest, const Header& header);

  // The bytes to be written next, in order; returns the number of pieces.
  std::size_t gather(std::span<std::span<const std::byte>> pieces) const;
  // The first `size` bytes returned by gather() were written.
  void consume(std::uint64_t size);

  // Drops all messages.
  void clear(LossCounts& lost);

  [[nodiscard]] bool empty() const { return bytes_ == 0; }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  friend class QueueShares;

  struct Level {
    ByteChain messages;
    std::uint32_t bytes = 0;
    std::uint32_t count = 0;
  };
  static constexpr std::size_t kLevels = 256;
  static_assert(sizeof(Level) * kLevels == BlockPool::kBlockSize);
  static constexpr std::size_t kNoLevel = kLevels;
  // So many waiting messages are looked at for an older sample.
  static constexpr std::size_t kSearchMax = StreamCounters::kStreamsMax;

  bool open();
  void close();
  void added(std::uint64_t size);
  void removed(std::uint64_t size);
  [[nodiscard]] std::uint64_t waiting_bytes() const { return bytes_ - begun_bytes_; }
  void ask_for_room(std::size_t size);
  void drop_for_others(std::size_t blocks, std::uint64_t keep);
  [[nodiscard]] std::uint64_t limit() const;
  [[nodiscard]] bool make_room(std::size_t size, std::uint8_t priority, LossCounts& replaced);
  [[nodiscard]] bool fits(std::size_t size, std::uint8_t priority) const;
  [[nodiscard]] std::uint64_t bytes_up_to(std::uint8_t priority) const;
  void drop_oldest(std::size_t level, LossCounts& replaced);
  bool replace_older(std::span<const std::byte> sample, const Header& header, std::uint8_t priority,
                     LossCounts& replaced);
  [[nodiscard]] bool is_sample(const Header& header) const {
    return streams_ != nullptr && StreamCounters::is_sample(header);
  }
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
  StreamCounters* streams_ = nullptr;  // null: all messages are kept
  QueueShares* shares_ = nullptr;      // null: all of the pool is this queue's
  QueueOwner* owner_ = nullptr;
  MessageQueue* next_ = nullptr;  // of the queues of shares_ that hold something
  MessageQueue* previous_ = nullptr;
  Time progress_at_{};       // when something was written, or the first message came
  std::uint64_t bytes_ = 0;  // in begun_ and all levels
  ByteChain begun_;          // the rest of a message that has been written in part
  std::size_t begun_bytes_ = 0;
  std::size_t begun_class_ = 0;
  BlockPool::Index index_ = BlockPool::kNone;  // block of the levels, while there are some
  // reserved so that a message can always become begun_
  BlockPool::Index spare_ = BlockPool::kNone;
  std::array<std::uint64_t, kLevels / 64> used_{};  // bit: this level has messages
};

}  // namespace tims::core
