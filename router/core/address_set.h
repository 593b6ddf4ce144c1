// All registered addresses in order, for those who ask for them page by page: the table (table.h)
// has them in no order, and looking through all of it would cost the same for one item as for all.
//
// Sorted arrays of bounded size: 4 to 16 bytes a mailbox, and an insertion moves 2 KiB at most.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <vector>

#include "tims/address.h"

namespace tims::core {

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
