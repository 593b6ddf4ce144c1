// The state of a slot and the hints that refer to it, two 64-bit words; and the order of hints that
// the owner of a mailbox keeps in private memory.
//
//             claim (sender)              commit (sender)            take (owner)
//   kFree ───────────────────▶ kWriting ─────────────────▶ kReadable ───────────▶ kLocked
//     ▲                           │  ▲                         │                     │
//     │        reclaim (router),  │  │  replace (sender: the   │     release (owner) │
//     │         give up (sender)  ▼  │  mailbox is full)       │                     │
//     └────── kAbandoned ◀────────┘  └─────────────────────────┘                     │
//     └──────────────────────────────────────────────────────────────────────────────┘
//
// Every arrow is one compare-and-swap on the slot's state word (release is a store: only the owner
// may leave kLocked). The state word is authoritative; rings contain only hints. A process that
// crashes between two steps therefore leaves at most a missing or a stale hint. Each claim
// increments the generation, which identifies stale hints and slow senders.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

namespace tims::shm {

enum class SlotState : std::uint8_t { kFree, kWriting, kReadable, kLocked, kAbandoned };

//  63        40 39      16 15      8 7     0
//  generation   writer     priority  state
struct SlotWord {
  SlotState state = SlotState::kFree;
  std::uint8_t priority = 0;     // while kWriting and kReadable
  std::uint32_t writer = 0;      // 24 bits; only while kWriting
  std::uint32_t generation = 0;  // 24 bits

  static constexpr std::uint32_t kMask24 = 0xFFFFFF;

  [[nodiscard]] constexpr std::uint64_t pack() const {
    return std::uint64_t{generation & kMask24} << 40 | std::uint64_t{writer & kMask24} << 16 |
           std::uint64_t{priority} << 8 | static_cast<std::uint8_t>(state);
  }
  static constexpr SlotWord unpack(std::uint64_t w) {
    return {static_cast<SlotState>(w & 0xFF), static_cast<std::uint8_t>(w >> 8),
            static_cast<std::uint32_t>(w >> 16) & kMask24, static_cast<std::uint32_t>(w >> 40)};
  }

  [[nodiscard]] constexpr SlotWord claimed_by(std::uint32_t owner, std::uint8_t prio) const {
    return {SlotState::kWriting, prio, owner & kMask24, (generation + 1) & kMask24};
  }
  [[nodiscard]] constexpr SlotWord committed() const {
    return {SlotState::kReadable, priority, 0, generation};
  }
  [[nodiscard]] constexpr SlotWord locked() const { return {SlotState::kLocked, 0, 0, generation}; }
  [[nodiscard]] constexpr SlotWord abandoned() const {
    return {SlotState::kAbandoned, 0, 0, generation};
  }
  [[nodiscard]] constexpr SlotWord freed() const { return {SlotState::kFree, 0, 0, generation}; }

  constexpr bool operator==(const SlotWord&) const = default;
};

//  63  48 47        24 23      16 15   0
//  lap    generation   priority   index
//
// An entry of a ring at position p is valid when its lap is lap_of(p): zeroed memory is empty, and
// nobody needs to clear what was read.
struct Hint {
  std::uint16_t lap = 0;
  std::uint32_t generation = 0;
  std::uint8_t priority = 0;
  std::uint16_t index = 0;

  [[nodiscard]] constexpr std::uint64_t pack() const {
    return std::uint64_t{lap} << 48 | std::uint64_t{generation & SlotWord::kMask24} << 24 |
           std::uint64_t{priority} << 16 | index;
  }
  static constexpr Hint unpack(std::uint64_t e) {
    return {static_cast<std::uint16_t>(e >> 48),
            static_cast<std::uint32_t>(e >> 24) & SlotWord::kMask24,
            static_cast<std::uint8_t>(e >> 16), static_cast<std::uint16_t>(e)};
  }

  // The state word of the slot while the message waits.
  [[nodiscard]] constexpr SlotWord readable() const {
    return {SlotState::kReadable, priority, 0, generation};
  }
};

// When a message was committed, as the sender saw it just before: the number of hints put into the
// arrival ring, and the number of requests to the owner to scan all slots instead. If A was sent
// before B, neither part of A's stamp is larger and at least one is smaller.
struct Stamp {
  std::uint32_t arrivals = 0;
  std::uint32_t rescans = 0;

  [[nodiscard]] constexpr std::uint64_t pack() const {
    return std::uint64_t{arrivals} << 32 | rescans;
  }
  static constexpr Stamp unpack(std::uint64_t s) {
    return {static_cast<std::uint32_t>(s >> 32), static_cast<std::uint32_t>(s)};
  }
  // Age seen from `now`; zero for messages committed after it. Both counters may wrap.
  [[nodiscard]] constexpr std::uint64_t age(Stamp now) const {
    return since(arrivals, now.arrivals) + since(rescans, now.rescans);
  }
  [[nodiscard]] constexpr bool not_after(Stamp now) const {
    return static_cast<std::int32_t>(now.arrivals - arrivals) >= 0 &&
           static_cast<std::int32_t>(now.rescans - rescans) >= 0;
  }

 private:
  static constexpr std::uint64_t since(std::uint32_t then, std::uint32_t now) {
    const auto passed = static_cast<std::int32_t>(now - then);
    return passed > 0 ? static_cast<std::uint64_t>(passed) : 0;
  }
};

// The owner's private order of the known messages: higher priority first, then order of insertion.
// Fixed memory; put, front and pop take constant time.
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
  // Inserts in front of hints of the same priority. Precondition: not full.
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

  // Removes the hints for which keep(hint) is false.
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
