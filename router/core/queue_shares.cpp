#include "router/core/queue_shares.h"

#include <algorithm>

#include "router/core/message_queue.h"

namespace tims::core {

bool QueueShares::stalled(const MessageQueue& queue) const {
  return !queue.empty() && now_ - queue.progress_at_ >= kPatience;
}

bool QueueShares::find_room(const MessageQueue& asker, std::size_t blocks) {
  if (pool_.available() >= blocks) return true;
  if (stalled(asker)) return false;
  const auto [available, share] = holdings(asker);
  if (available < std::uint64_t{blocks} * BlockPool::kBlockSize) return false;
  while (MessageQueue* queue = largest(asker, true, 0)) {
    queue->drop_for_others(blocks, 0);
    if (pool_.available() >= blocks) return true;
  }
  while (MessageQueue* queue = largest(asker, false, share)) {
    queue->drop_for_others(blocks, share);
    if (pool_.available() >= blocks) return true;
  }
  while (MessageQueue* queue = longest_stalled(asker)) {
    queue->owner_->give_up();
    if (pool_.available() >= blocks) return true;
  }
  return false;
}

QueueShares::Holdings QueueShares::holdings(const MessageQueue& asker) const {
  const std::uint64_t all =
      (std::uint64_t{pool_.available()} + pool_.used()) * BlockPool::kBlockSize;
  std::uint64_t readers = 1;
  for (const MessageQueue* q = first_; q != nullptr; q = q->next_) readers += q == &asker ? 0 : 1;
  Holdings sum{.available = std::uint64_t{pool_.available()} * BlockPool::kBlockSize,
               .share = all / readers};
  for (const MessageQueue* q = first_; q != nullptr; q = q->next_) {
    if (q == &asker) continue;
    if (stalled(*q))
      sum.available += q->bytes();
    else if (q->bytes() > sum.share)
      sum.available += std::min(q->waiting_bytes(), q->bytes() - sum.share);
  }
  return sum;
}

// Of the queues with waiting messages and more than `above` bytes; null when there is none.
MessageQueue* QueueShares::largest(const MessageQueue& asker, bool has_stalled,
                                   std::uint64_t above) const {
  MessageQueue* found = nullptr;
  for (MessageQueue* q = first_; q != nullptr; q = q->next_) {
    if (q == &asker || q->waiting_bytes() == 0 || q->bytes() <= above) continue;
    if (stalled(*q) != has_stalled) continue;
    if (found == nullptr || q->bytes() > found->bytes()) found = q;
  }
  return found;
}

// Of those that hold at least an equal part of what stalled readers hold: disconnecting one of
// the others would hardly help.
MessageQueue* QueueShares::longest_stalled(const MessageQueue& asker) const {
  std::uint64_t bytes = 0;
  std::uint64_t count = 0;
  const auto candidate = [&](const MessageQueue& q) { return &q != &asker && stalled(q); };
  for (const MessageQueue* q = first_; q != nullptr; q = q->next_) {
    if (!candidate(*q)) continue;
    bytes += q->bytes();
    ++count;
  }
  MessageQueue* found = nullptr;
  for (MessageQueue* q = first_; q != nullptr; q = q->next_) {
    if (!candidate(*q) || q->bytes() * count < bytes) continue;
    if (found == nullptr || q->progress_at_ < found->progress_at_) found = q;
  }
  return found;
}

void QueueShares::join(MessageQueue& queue) {
  queue.previous_ = nullptr;
  queue.next_ = first_;
  if (first_ != nullptr) first_->previous_ = &queue;
  first_ = &queue;
}

void QueueShares::leave(MessageQueue& queue) {
  (queue.previous_ == nullptr ? first_ : queue.previous_->next_) = queue.next_;
  if (queue.next_ != nullptr) queue.next_->previous_ = queue.previous_;
  queue.next_ = queue.previous_ = nullptr;
}

}  // namespace tims::core
