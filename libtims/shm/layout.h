// What lies where in shared memory. The drawing and the crash rules: LAYOUT.md.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "tims/message.h"

// The atomics of shared memory, behind one name: a test can put its own in their place, by naming
// its header in TIMS_ATOMIC_HEADER, and so run the interleavings of the very code that ships.
#ifdef TIMS_ATOMIC_HEADER
#include TIMS_ATOMIC_HEADER
#else

namespace tims::shm {

template <typename T>
class Atomic {
 public:
  Atomic() = default;
  explicit Atomic(T value) : value_(value) {}

  T load(std::memory_order order) const { return value_.load(order); }
  void store(T value, std::memory_order order) { value_.store(value, order); }
  bool compare_exchange(T expected, T desired, std::memory_order order) {
    return value_.compare_exchange_strong(expected, desired, order, std::memory_order_relaxed);
  }
  T fetch_add(T n, std::memory_order order) { return value_.fetch_add(n, order); }
  // The futex word's address, for the system call.
  const std::atomic<T>* raw() const { return &value_; }

 private:
  static_assert(std::atomic<T>::is_always_lock_free, "shared between processes");
  std::atomic<T> value_;
};

}  // namespace tims::shm

#endif

namespace tims::shm {

using Word32 = Atomic<std::uint32_t>;
using Word64 = Atomic<std::uint64_t>;

inline constexpr std::uint32_t kLayoutVersion = 2;
inline constexpr std::uint32_t kReady = 0x4D584254;  // "TBXM"; written last
inline constexpr std::uint32_t kSlotsMax = 65535;
inline constexpr std::uint32_t kMessageMax = 1U << 30;  // bytes, header included
inline constexpr std::size_t kLine = 64;
inline constexpr std::size_t kPair = 2 * kLine;  // as the processor fetches them

// Entries of a ring beyond two for each slot. Tests make it small, so that a ring's end is near.
#ifndef TIMS_RING_SPARE
#define TIMS_RING_SPARE 64
#endif
inline constexpr std::uint32_t kRingSpare = TIMS_RING_SPARE;

// How a sender wakes the owner.
enum class WakeKind : std::uint32_t {
  kFutex,     // on MailboxHeader::sleep
  kSocket,    // a socket of the owner's (os/wakeup.h)
  kDoorbell,  // an eventfd that came with it: the mailbox is a client's uplink to the router
};

struct MailboxHeader {
  // Written once, before `ready`.
  alignas(kLine) Word32 ready;
  std::uint32_t version;
  std::uint32_t address;
  std::uint32_t slots;
  std::uint32_t message_max;  // bytes, header included
  WakeKind wake;
  std::uint32_t owner_pid;
  std::uint32_t long_places;  // for long bodies

  // Read by everybody for each message, seldom written: when the owner falls asleep, when the
  // priority of what is sent changes, when the mailbox closes.
  alignas(kLine) Word32 sleep;  // odd: the owner sleeps
  Word32 closed;                // not 0: senders must look the address up again
  // At least the highest priority announced since the owner last lowered it: as long as it is not
  // above what the owner has in hand, the owner leaves the arrival ring to the senders.
  Word32 highest;

  // Moved by senders.
  alignas(kLine) Word64 arrival_tail;
  Word64 free_head;

  // Moved by the owner.
  alignas(kLine) Word64 arrival_head;
  Word64 received;

  // Seldom written, by anybody.
  alignas(kLine) Word64 rescans;  // raised: hints are missing, the owner must look at every slot
  Word64 replaced;
  Word64 refused;
  Word64 too_big;
  Word64 reclaimed;
};

struct SlotHeader {
  Word64 word;   // SlotWord
  Word64 stamp;  // Stamp
  // the message's header follows, 16 bytes in native order; then the body, or of a long one the
  // number of its place
};

static_assert(offsetof(MailboxHeader, ready) == 0);
static_assert(offsetof(MailboxHeader, version) == 4);
static_assert(offsetof(MailboxHeader, address) == 8);
static_assert(offsetof(MailboxHeader, slots) == 12);
static_assert(offsetof(MailboxHeader, message_max) == 16);
static_assert(offsetof(MailboxHeader, wake) == 20);
static_assert(offsetof(MailboxHeader, owner_pid) == 24);
static_assert(offsetof(MailboxHeader, long_places) == 28);
static_assert(offsetof(MailboxHeader, sleep) == 64);
static_assert(offsetof(MailboxHeader, closed) == 68);
static_assert(offsetof(MailboxHeader, highest) == 72);
static_assert(offsetof(MailboxHeader, arrival_tail) == 128);
static_assert(offsetof(MailboxHeader, free_head) == 136);
static_assert(offsetof(MailboxHeader, arrival_head) == 192);
static_assert(offsetof(MailboxHeader, received) == 200);
static_assert(offsetof(MailboxHeader, rescans) == 256);
static_assert(offsetof(MailboxHeader, reclaimed) == 288);
static_assert(sizeof(MailboxHeader) == 320);
static_assert(sizeof(SlotHeader) == 16);

// Slots up to this size are in one piece. Of larger ones the short messages, by far the most in
// number, lie close together, so that they share pages and cache; only long ones are far apart.
inline constexpr std::size_t kWholeMax = 4096;
inline constexpr std::size_t kDividedSlot = 17 * kPair;  // odd: neighbours share no line of a cache

// Where the parts of a mailbox lie, computed from the numbers that are its size.
struct Geometry {
  std::uint32_t slots = 0;
  std::uint32_t message_max = 0;
  std::uint32_t ring = 0;     // entries of the arrival ring and of the free ring each, power of two
  std::size_t stride = 0;     // of slots, bytes
  std::size_t short_max = 0;  // longest body that lies in its slot
  std::uint32_t long_places = 0;  // of longer ones
  std::size_t long_stride = 0;
  std::size_t arrival_at = 0;
  std::size_t free_at = 0;
  std::size_t holders_at = 0;  // of shared places
  std::size_t slots_at = 0;
  std::size_t long_at = 0;
  std::size_t bytes = 0;  // all of it

  static constexpr bool valid(std::uint32_t slots, std::uint32_t message_max) {
    return slots >= 1 && slots <= kSlotsMax && message_max >= kHeaderSize &&
           message_max <= kMessageMax;
  }

  // `long_places`: fewer than slots when they are shared, 0: one for each.
  static constexpr Geometry of(std::uint32_t slots, std::uint32_t message_max,
                               std::uint32_t long_places = 0) {
    Geometry g{.slots = slots, .message_max = message_max};
    // Room for stale hints beside one for each slot.
    g.ring = std::bit_ceil(2 * slots + kRingSpare);
    const std::size_t whole = sizeof(SlotHeader) + message_max;
    const bool divided = whole > kWholeMax;
    const std::size_t slot = divided ? kDividedSlot : whole;
    // From two lines on in pairs.
    g.stride = up(slot, slot > kLine ? kPair : kLine);
    g.short_max = slot - sizeof(SlotHeader) - kHeaderSize;
    if (divided) {
      g.long_places = long_places == 0 || long_places > slots ? slots : long_places;
      // An odd number of pairs: neighbours do not compete for the same lines of a cache.
      g.long_stride = ((message_max - kHeaderSize + kPair - 1) / kPair | 1) * kPair;
    }
    g.arrival_at = sizeof(MailboxHeader);
    g.free_at = g.arrival_at + g.ring * sizeof(std::uint64_t);
    g.holders_at = g.free_at + g.ring * sizeof(std::uint64_t);
    const std::size_t holders = g.shares_places() ? g.long_places : 0;
    g.slots_at = up(g.holders_at + holders * sizeof(std::uint64_t), kPair);
    g.long_at = g.slots_at + g.slots * g.stride;
    g.bytes = g.long_at + g.long_places * g.long_stride;
    return g;
  }

  [[nodiscard]] constexpr bool shares_places() const {
    return long_places != 0 && long_places < slots;
  }
  [[nodiscard]] constexpr std::uint16_t lap_of(std::uint64_t position) const {
    return static_cast<std::uint16_t>(position / ring + 1);
  }

 private:
  static constexpr std::size_t up(std::size_t size, std::size_t unit) {
    return (size + unit - 1) / unit * unit;
  }
};

inline constexpr std::size_t kMailboxAlign = 128;  // of a mailbox inside a segment

}  // namespace tims::shm
