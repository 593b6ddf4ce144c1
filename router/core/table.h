// Who owns which address: a flat hash map that is asked once or twice for every message.
//
// Open addressing with linear probing in a power of two of 16-byte entries, at most three quarters
// full; removal shifts later entries back, so there are no tombstones and look-ups do not grow
// slower with time. Worst case, just after growing: 16 / (3/8) = 43 bytes a mailbox, which leaves
// 21 of the 64 we allow for the owner's list (clients.h) and for the order (address_set.h).
//
// The hash is keyed with a secret: a client that chooses its addresses cannot choose collisions.
// All 2^32 addresses are keys like any other, also 0: an entry is empty when nobody owns it.
//
// Growing moves everything: one registration in a million costs some ten milliseconds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "router/core/ids.h"
#include "tims/address.h"

namespace tims::core {

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

}  // namespace tims::core
