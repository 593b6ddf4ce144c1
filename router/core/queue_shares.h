// The memory that the queues of all slow readers share (MessageQueue with Share::kFair).
//
// A queue without enough room asks for it. The readers give it in this order: those that have not
// read anything for a while (kPatience) lose waiting messages; those that hold more than an equal
// share lose waiting messages down to the share; and of those that have not read anything for a
// while, the one that stopped first is disconnected. A message that is written in part keeps its
// memory until then, so a client that reads is never disconnected because others do not. Pure.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

#include "router/core/byte_chain.h"
#include "router/core/statistics.h"
#include "tims/time.h"

namespace tims::core {

class MessageQueue;

// The owner of a queue that shares memory. Called while another queue asks for room.
class QueueOwner {
 public:
  // Waiting messages were dropped.
  virtual void on_dropped(const LossCounts& lost) = 0;
  // The reader has stopped reading: release all memory of the queue now, and disconnect it later.
  virtual void give_up() = 0;

 protected:
  ~QueueOwner() = default;
};

class QueueShares {
 public:
  // A reader on a slow network makes some progress within this time.
  static constexpr Duration kPatience = std::chrono::milliseconds(250);

  explicit QueueShares(BlockPool& pool) : pool_(pool) {}
  QueueShares(const QueueShares&) = delete;
  QueueShares& operator=(const QueueShares&) = delete;

  [[nodiscard]] BlockPool& pool() const { return pool_; }

  // The time of what follows.
  void set_now(Time now) { now_ = now; }
  [[nodiscard]] Time now() const { return now_; }
  [[nodiscard]] bool stalled(const MessageQueue& queue) const;

  // True: the pool has `blocks` free blocks. Nothing is dropped when this cannot be achieved, nor
  // for a queue whose own reader has stopped.
  bool find_room(const MessageQueue& asker, std::size_t blocks);

 private:
  friend class MessageQueue;
  void join(MessageQueue& queue);
  void leave(MessageQueue& queue);

  struct Holdings {
    std::uint64_t available = 0;  // bytes that find_room() can make available
    std::uint64_t share = 0;      // bytes, an equal part of the pool for each reader
  };
  [[nodiscard]] Holdings holdings(const MessageQueue& asker) const;
  MessageQueue* largest(const MessageQueue& asker, bool stalled, std::uint64_t above) const;
  MessageQueue* longest_stalled(const MessageQueue& asker) const;

  BlockPool& pool_;
  Time now_{};
  MessageQueue* first_ = nullptr;  // queues that hold something, linked with each other
};

}  // namespace tims::core
