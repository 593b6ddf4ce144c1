// The two containers of all registered addresses: Table, a flat hash map with one or two look-ups
// per message, and AddressSet, which keeps them in order for paged queries.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <memory>
#include <vector>

#include "router/core/types.h"
#include "tims/address.h"

namespace tims::core {

// Maps each address to its owner: a flat hash map with one or two look-ups per message.
//
// Open addressing with linear probing in a power of two of 16-byte entries, at most three quarters
// full; removal shifts later entries back, so there are no tombstones and look-ups do not grow
// slower with time. Worst case, just after growing: 16 / (3/8) = 43 bytes a mailbox, which leaves
// 21 of the 64 we allow for the owner's list (registrations.h) and for the order (AddressSet).
//
// The hash is keyed with a secret, so a client that chooses its addresses cannot choose
// collisions. All 2^32 addresses are valid keys, including 0: an entry is empty when it has no
// owner.
//
// Growing rehashes everything: one registration in a million costs some ten milliseconds.
struct HashSeed {  // random, drawn at start
  std::uint64_t first = 0;
  std::uint64_t second = 0;
};

class Table {
 public:
  struct Entry {
    Address address;
    ClientId owner;  // kNoClient: this entry is empty
    // the port's number for the mailbox; for a link, the number of its origin
    std::uint32_t handle = 0;
    std::uint32_t position = 0;  // index in the owner's list
  };
  static_assert(sizeof(Entry) == 16);

  explicit Table(HashSeed seed);

  // Null when the address has no owner. Valid until the next insert() or erase().
  [[nodiscard]] const Entry* find(Address address) const;
  [[nodiscard]] Entry* find(Address address) {
    return const_cast<Entry*>(static_cast<const Table*>(this)->find(address));
  }

  // Precondition: the address has no owner, and the entry has one.
  void insert(const Entry& entry);
  // Precondition: `entry` was returned by find().
  void erase(const Entry* entry);

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t memory_bytes() const { return (mask_ + 1) * sizeof(Entry); }

  template <typename Visit>
  void for_each(Visit visit) const {
    for (std::size_t i = 0; i <= mask_; ++i) {
      if (entries_[i].owner) visit(entries_[i]);
    }
  }

 private:
  // Product of two 64-bit numbers, with its upper and lower halves combined by exclusive or.
  static std::uint64_t fold(std::uint64_t a, std::uint64_t b) {
#ifdef __SIZEOF_INT128__
    __extension__ using Wide = unsigned __int128;
    const Wide product = Wide{a} * b;
    return static_cast<std::uint64_t>(product) ^ static_cast<std::uint64_t>(product >> 64);
#else  // words of 32 bits
    constexpr std::uint64_t kLow = 0xFFFFFFFF;
    const std::uint64_t first = (a >> 32) * (b & kLow);
    const std::uint64_t second = (a & kLow) * (b >> 32);
    const std::uint64_t carry = ((a & kLow) * (b & kLow) >> 32) + (first & kLow) + (second & kLow);
    return (a * b) ^ ((a >> 32) * (b >> 32) + (first >> 32) + (second >> 32) + (carry >> 32));
#endif
  }
  [[nodiscard]] std::size_t home(Address address) const {
    const std::uint64_t once = fold(address.raw() ^ seed_.first, seed_.second);
    return static_cast<std::size_t>(fold(once ^ seed_.second, 0x9E3779B97F4A7C15ULL)) & mask_;
  }
  void place(const Entry& entry);
  void grow();

  HashSeed seed_;
  std::size_t mask_;  // capacity - 1
  std::size_t size_ = 0;
  std::unique_ptr<Entry[]> entries_;
};

inline const Table::Entry* Table::find(Address address) const {
  for (std::size_t i = home(address);; i = (i + 1) & mask_) {
    const Entry& entry = entries_[i];
    if (!entry.owner) return nullptr;
    if (entry.address == address) return &entry;
  }
}

// All registered addresses in order, for paged queries: the table is unordered, and a page of it
// would cost a scan of the whole table.
//
// Sorted arrays of bounded size: 4 to 16 bytes a mailbox, and an insertion moves 2 KiB at most.
class AddressSet {
 public:
  AddressSet() : chunks_{{0, {}}} {}

  // Precondition: the address is not in the set.
  void insert(Address address);
  // Precondition: the address is in the set.
  void erase(Address address);

  // In order, from `first` on, until `visit` returns false.
  template <typename Visit>
  void for_each_from(Address first, Visit visit) const {
    for (auto at = chunk_of(first.raw()); at != chunks_.end(); ++at) {
      const Chunk& chunk = at->second;
      for (auto i = std::ranges::lower_bound(chunk, first.raw()); i != chunk.end(); ++i) {
        if (!visit(Address(*i))) return;
      }
    }
  }

  [[nodiscard]] std::size_t memory_bytes() const {
    return chunks_.size() * (kChunkMax * sizeof(std::uint32_t) + kNodeBytes);
  }

 private:
  static constexpr std::size_t kChunkMax = 512;
  // Approximate size of a map node, including the allocator's overhead.
  static constexpr std::size_t kNodeBytes = 96;
  using Chunk = std::vector<std::uint32_t>;
  // Keyed by the lowest address that belongs into the chunk; a chunk for 0 always exists.
  using Chunks = std::map<std::uint32_t, Chunk>;

  [[nodiscard]] Chunks::const_iterator chunk_of(std::uint32_t address) const {
    return std::prev(chunks_.upper_bound(address));
  }
  void merge_with_next(Chunks::iterator at);

  Chunks chunks_;
};

}  // namespace tims::core
