// Layout of a mailbox in shared memory, and a checked view of it for this process. The diagram and
// the rules for crashes are in LAYOUT.md.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "shm/slot.h"
#include "tims/message.h"
#include "tims/result.h"

// Atomics in shared memory. A test can substitute its own by naming a header in TIMS_ATOMIC_HEADER,
// and so explore the interleavings of the production code.
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
  // Address of the futex word for the system call.
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
inline constexpr std::size_t kPair = 2 * kLine;  // the unit that the processor fetches

// Entries of a ring in addition to two for each slot. Tests make it small to reach the end of a
// ring quickly.
#ifndef TIMS_RING_SPARE
#define TIMS_RING_SPARE 64
#endif
inline constexpr std::uint32_t kRingSpare = TIMS_RING_SPARE;

// How a sender wakes the owner.
enum class WakeKind : std::uint32_t {
  kFutex,     // on MailboxHeader::sleep
  kSocket,    // a socket created by the owner (os/wakeup.h)
  kDoorbell,  // an eventfd sent with the mailbox: the mailbox is a client's uplink to the router
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

  // Read by all processes for each message, but seldom written: when the owner goes to sleep, when
  // the highest announced priority changes, when the mailbox is closed.
  alignas(kLine) Word32 sleep;  // odd: the owner sleeps
  Word32 closed;                // not 0: senders must look the address up again
  // At least the highest priority announced since the owner last lowered it. While it is not above
  // the priority that the owner has in hand, the owner does not access the arrival ring.
  Word32 highest;

  // Advanced by senders.
  alignas(kLine) Word64 arrival_tail;
  Word64 free_head;

  // Advanced by the owner.
  alignas(kLine) Word64 arrival_head;
  Word64 received;

  // Seldom written, by any process.
  // incremented when hints are missing and the owner must look at every slot
  alignas(kLine) Word64 rescans;
  Word64 replaced;
  Word64 refused;
  Word64 too_big;
  Word64 reclaimed;
};

struct SlotHeader {
  Word64 word;   // SlotWord
  Word64 stamp;  // Stamp
  // The message header follows: 16 bytes in native order; then the body, or for a long body the
  // number of its place.
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

// Slots up to this size are contiguous. In mailboxes with larger slots, short messages, which are
// by far the most frequent, are stored close together and share pages and cache lines; only long
// bodies are stored far apart.
inline constexpr std::size_t kWholeMax = 4096;
// odd: neighbouring slots do not map to the same cache lines
inline constexpr std::size_t kDividedSlot = 17 * kPair;

// Offsets of the parts of a mailbox, computed from its size parameters.
struct Geometry {
  std::uint32_t slots = 0;
  std::uint32_t message_max = 0;
  // entries of the arrival ring and of the free ring each; a power of two
  std::uint32_t ring = 0;
  std::size_t stride = 0;         // between slots, bytes
  std::size_t short_max = 0;      // longest body that is stored in its slot
  std::uint32_t long_places = 0;  // places for longer bodies
  std::size_t long_stride = 0;
  std::size_t arrival_at = 0;
  std::size_t free_at = 0;
  std::size_t holders_at = 0;  // offset of the holders of shared places
  std::size_t slots_at = 0;
  std::size_t long_at = 0;
  // Total size: what another process states must not wrap round where a pointer has 32 bits.
  std::uint64_t bytes = 0;

  static constexpr bool valid(std::uint32_t slots, std::uint32_t message_max) {
    return slots >= 1 && slots <= kSlotsMax && message_max >= kHeaderSize &&
           message_max <= kMessageMax;
  }

  // `long_places`: less than `slots` when they are shared; 0: one for each slot.
  static constexpr Geometry of(std::uint32_t slots, std::uint32_t message_max,
                               std::uint32_t long_places = 0) {
    Geometry g{.slots = slots, .message_max = message_max};
    // Room for stale hints in addition to one hint for each slot.
    g.ring = std::bit_ceil(2 * slots + kRingSpare);
    const std::size_t whole = sizeof(SlotHeader) + message_max;
    const bool divided = whole > kWholeMax;
    const std::size_t slot = divided ? kDividedSlot : whole;
    // Slots larger than one line are aligned to pairs of lines.
    g.stride = up(slot, slot > kLine ? kPair : kLine);
    g.short_max = slot - sizeof(SlotHeader) - kHeaderSize;
    if (divided) {
      g.long_places = long_places == 0 || long_places > slots ? slots : long_places;
      // An odd number of pairs: neighbouring places do not map to the same cache lines.
      g.long_stride = ((message_max - kHeaderSize + kPair - 1) / kPair | 1) * kPair;
    }
    g.arrival_at = sizeof(MailboxHeader);
    g.free_at = g.arrival_at + g.ring * sizeof(std::uint64_t);
    g.holders_at = g.free_at + g.ring * sizeof(std::uint64_t);
    const std::size_t holders = g.shares_places() ? g.long_places : 0;
    g.slots_at = up(g.holders_at + holders * sizeof(std::uint64_t), kPair);
    g.long_at = g.slots_at + g.slots * g.stride;
    g.bytes = g.long_at + std::uint64_t{g.long_places} * g.long_stride;
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

// A checked view of a mailbox in shared memory. Values written by another process are read once,
// checked and stored here. Afterwards every index goes through a function that cannot leave the
// mapping, whatever another process writes into it.
class MailboxView {
 public:
  MailboxView() = default;

  // Opens a mailbox that another process laid out at `offset` of `mapping`. The detail of
  // kBadLayout states the problem.
  static Result<MailboxView> open(std::span<std::byte> mapping, std::uint64_t offset);

  struct Options {
    Address address;
    std::uint32_t slots = 1;
    std::uint32_t message_max = kHeaderSize;
    std::uint32_t long_places = 0;  // 0: one for each slot
    WakeKind wake = WakeKind::kFutex;
    std::uint32_t owner_pid = 0;
  };
  // Lays out a new mailbox in zeroed memory; the caller has checked sizes and alignment.
  static MailboxView create(std::span<std::byte> mapping, std::uint64_t offset,
                            const Options& options);

  [[nodiscard]] MailboxHeader& header() const { return *header_; }
  [[nodiscard]] const Geometry& geometry() const { return geometry_; }
  [[nodiscard]] WakeKind wake() const { return wake_; }
  [[nodiscard]] Address address() const { return address_; }

  [[nodiscard]] Word64& arrival(std::uint64_t position) const {
    return arrival_[position & (geometry_.ring - 1)];
  }
  [[nodiscard]] Word64& free(std::uint64_t position) const {
    return free_[position & (geometry_.ring - 1)];
  }
  // Precondition: index < geometry().slots.
  [[nodiscard]] SlotHeader& slot(std::uint32_t index) const {
    // NOLINTNEXTLINE(clang-analyzer-core.uninitialized.UndefReturn): a view that was made has slots
    return *reinterpret_cast<SlotHeader*>(slots_ + index * geometry_.stride);
  }
  // The header of the message in a slot: kHeaderSize bytes.
  [[nodiscard]] std::byte* message_header(std::uint32_t index) const {
    return slots_ + index * geometry_.stride + sizeof(SlotHeader);
  }
  // Body in the slot, of at most geometry().short_max bytes.
  [[nodiscard]] std::byte* short_body(std::uint32_t index) const {
    return message_header(index) + kHeaderSize;
  }
  // Body in a long place. Precondition: place < geometry().long_places.
  [[nodiscard]] std::byte* long_body(std::uint32_t place) const {
    return long_ + place * geometry_.long_stride;
  }
  // Holder of a shared place. Precondition: place < geometry().long_places.
  [[nodiscard]] Word64& holder(std::uint32_t place) const { return holders_[place]; }
  void prefetch(std::uint32_t index) const {
    const std::byte* at = slots_ + index * geometry_.stride;
    __builtin_prefetch(at, 1);
    __builtin_prefetch(at + kLine, 1);
  }

 private:
  MailboxView(std::byte* base, const Geometry& geometry);

  MailboxHeader* header_ = nullptr;
  Word64* arrival_ = nullptr;
  Word64* free_ = nullptr;
  Word64* holders_ = nullptr;
  std::byte* slots_ = nullptr;
  std::byte* long_ = nullptr;
  Geometry geometry_;
  WakeKind wake_ = WakeKind::kFutex;
  Address address_;
};

// --- Cleaning up after a crashed client in the mailboxes of other clients. Called by the router;
// the functions are idempotent and safe while senders and the owner are running.

// Reclaims the slots that were being written by writers for which `is_dead(writer)` holds, and
// makes the owner look for messages that were committed but not announced. Returns the number of
// slots. The caller then wakes the owner, because the crashed client may not have done so.
template <typename IsDead>
std::uint32_t reclaim(const MailboxView& view, IsDead is_dead) {
  std::uint32_t taken = 0;
  for (std::uint32_t i = 0; i < view.geometry().slots; ++i) {
    Word64& shared = view.slot(i).word;
    const SlotWord word = SlotWord::unpack(shared.load(std::memory_order_acquire));
    if (word.state != SlotState::kWriting || !is_dead(word.writer)) continue;
    if (shared.compare_exchange(word.pack(), word.abandoned().pack(), std::memory_order_acq_rel))
      ++taken;
  }
  view.header().reclaimed.fetch_add(taken, std::memory_order_relaxed);
  view.header().rescans.fetch_add(1, std::memory_order_seq_cst);
  return taken;
}

// Marks the mailbox closed because its owner is gone: senders must look the address up again.
inline void condemn(const MailboxView& view) {
  view.header().closed.store(1, std::memory_order_release);
}

// Opens the mailbox again after its owner has registered it again, although it was condemned
// before.
inline void pardon(const MailboxView& view) {
  view.header().closed.store(0, std::memory_order_release);
}

}  // namespace tims::shm
