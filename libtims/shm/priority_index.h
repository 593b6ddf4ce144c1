// The owner's private order of the messages it knows of: higher priority first, then as put in.
// Fixed memory; put, front and pop take constant time.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "shm/slot.h"

namespace tims::shm {

class PriorityIndex {
 public:
  explicit PriorityIndex(std::uint32_t capacity) : nodes_(capacity) { clear(); }

  void clear() {
    heads_.fill(kNone);
    used_.fill(0);
    size_ = 0;
    free_ = 0;
    for (std::uint32_t i = 0; i < nodes_.size(); ++i)
      nodes_[i].next = i + 1 < nodes_.size() ? i + 1 : kNone;
  }

  [[nodiscard]] bool full() const { return free_ == kNone; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] std::uint32_t size() const { return size_; }

  // Precondition: not full.
  void put(Hint hint) {
    const std::uint32_t node = take_node(hint);
    const std::uint8_t priority = hint.priority;
    if (heads_[priority] == kNone) {
      heads_[priority] = node;
      used_[priority / 64] |= std::uint64_t{1} << priority % 64;
    } else {
      nodes_[tails_[priority]].next = node;
    }
    tails_[priority] = node;
  }
  // In front of its equals. Precondition: not full.
  void put_back(Hint hint) {
    const std::uint32_t node = take_node(hint);
    const std::uint8_t priority = hint.priority;
    if (heads_[priority] == kNone) tails_[priority] = node;
    nodes_[node].next = heads_[priority];
    heads_[priority] = node;
    used_[priority / 64] |= std::uint64_t{1} << priority % 64;
  }

  // Precondition: not empty.
  [[nodiscard]] Hint front() const { return nodes_[heads_[top()]].hint; }
  void pop() {
    const std::uint8_t priority = top();
    const std::uint32_t node = heads_[priority];
    heads_[priority] = nodes_[node].next;
    if (heads_[priority] == kNone) used_[priority / 64] &= ~(std::uint64_t{1} << priority % 64);
    nodes_[node].next = free_;
    free_ = node;
    --size_;
  }

  // Forgets the hints for which keep(hint) is false.
  template <typename Keep>
  void retain(Keep keep) {
    std::vector<Hint> kept;
    kept.reserve(size_);
    for (; !empty(); pop())
      if (keep(front())) kept.push_back(front());
    for (const Hint& hint : kept) put(hint);
  }

 private:
  static constexpr std::uint32_t kNone = ~0U;
  struct Node {
    Hint hint;
    std::uint32_t next = kNone;
  };

  [[nodiscard]] std::uint8_t top() const {
    for (std::size_t word = used_.size(); word-- > 0;)
      if (used_[word] != 0)
        return static_cast<std::uint8_t>(word * 64 + 63 -
                                         static_cast<unsigned>(std::countl_zero(used_[word])));
    return 0;
  }
  std::uint32_t take_node(Hint hint) {
    const std::uint32_t node = free_;
    free_ = nodes_[node].next;
    nodes_[node] = {hint, kNone};
    ++size_;
    return node;
  }

  std::vector<Node> nodes_;
  std::array<std::uint32_t, 256> heads_{};
  std::array<std::uint32_t, 256> tails_{};
  std::array<std::uint64_t, 4> used_{};
  std::uint32_t free_ = 0;
  std::uint32_t size_ = 0;
};

}  // namespace tims::shm
