// The two containers of all registered addresses: Table, a flat hash map that is asked once or
// twice for every message, and AddressSet, which has them in order for those who ask page by page.
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

// Who owns which address: a flat hash map that is asked once or twice for every message.
//
// Open addressing with linear probing in a power of two of 16-byte entries, at most three quarters
// full; removal shifts later entries back, so there are no tombstones and look-ups do not grow
// slower with time. Worst case, just after growing: 16 / (3/8) = 43 bytes a mailbox, which leaves
// 21 of the 64 we allow for the owner's list (registrations.h) and for the order (AddressSet).
//
// The hash is keyed with a secret: a client that chooses its addresses cannot choose collisions.
// All 2^32 addresses are keys like any other, also 0: an entry is empty when nobody owns it.
//
// Growing moves everything: one registration in a million costs some ten milliseconds.
struct HashSeed {  // random, drawn at start
  std::uint64_t first = 0;
  std::uint64_t second = 0;
};

class Table {
 public:
  struct Entry {
    Address address;
    ClientId owner;              // kNoClient: this entry is empty
    std::uint32_t handle = 0;    // the port's number for the mailbox; of a link's, of its origin
    std::uint32_t position = 0;  // in the owner's list
  };
  static_assert(sizeof(Entry) == 16);

  explicit Table(HashSeed seed);

  // Null when nobody owns the address. Valid until the next insert() or erase().
  [[nodiscard]] const Entry* find(Address address) const;
  [[nodiscard]] Entry* find(Address address) {
    return const_cast<Entry*>(static_cast<const Table*>(this)->find(address));
  }

  // The address is in nobody's hands, and the entry has an owner.
  void insert(const Entry& entry);
  // `entry` came from find().
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
  // Product of two 64-bit numbers, its halves folded together.
  static std::uint64_t fold(std::uint64_t a, std::uint64_t b) {
    __extension__ using Wide = unsigned __int128;
    const Wide product = Wide{a} * b;
    return static_cast<std::uint64_t>(product) ^ static_cast<std::uint64_t>(product >> 64);
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

// All registered addresses in order, for those who ask for them page by page: the table
// has them in no order, and looking through all of it would cost the same for one item as for all.
//
// Sorted arrays of bounded size: 4 to 16 bytes a mailbox, and an insertion moves 2 KiB at most.
class AddressSet {
 public:
  AddressSet() : chunks_{{0, {}}} {}

  // It is not here yet.
  void insert(Address address);
  // It is here.
  void erase(Address address);

  // In order, from `first` on, until `visit` says false.
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
  static constexpr std::size_t kNodeBytes = 96;  // about: of the map and of the allocator
  using Chunk = std::vector<std::uint32_t>;
  // By the lowest address that belongs into each; there is always one for 0.
  using Chunks = std::map<std::uint32_t, Chunk>;

  [[nodiscard]] Chunks::const_iterator chunk_of(std::uint32_t address) const {
    return std::prev(chunks_.upper_bound(address));
  }
  void merge_with_next(Chunks::iterator at);

  Chunks chunks_;
};

}  // namespace tims::core
