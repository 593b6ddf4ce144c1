#include "router/core/address_set.h"

namespace tims::core {

void AddressSet::insert(Address address) {
  auto at = std::prev(chunks_.upper_bound(address.raw()));
  if (at->second.size() == kChunkMax) {
    // Who registers in ascending order leaves full arrays behind, everybody else halves.
    Chunk& full = at->second;
    const bool behind = address.raw() > full.back();
    const auto middle = behind ? full.end() : full.begin() + kChunkMax / 2;
    const std::uint32_t first = behind ? address.raw() : *middle;
    const auto upper = chunks_.emplace(first, Chunk(middle, full.end())).first;
    full.erase(middle, full.end());
    if (address.raw() >= first) at = upper;
  }
  Chunk& chunk = at->second;
  chunk.insert(std::ranges::upper_bound(chunk, address.raw()), address.raw());
}

void AddressSet::erase(Address address) {
  const auto at = std::prev(chunks_.upper_bound(address.raw()));
  Chunk& chunk = at->second;
  chunk.erase(std::ranges::lower_bound(chunk, address.raw()));
  if (chunk.empty() && at->first != 0) {
    chunks_.erase(at);
  } else if (chunk.size() < kChunkMax / 4) {
    merge_with_next(at);
  }
}

// So that arrays with few addresses do not stay behind.
void AddressSet::merge_with_next(Chunks::iterator at) {
  const auto next = std::next(at);
  if (next == chunks_.end() || at->second.size() + next->second.size() > kChunkMax / 2) return;
  at->second.insert(at->second.end(), next->second.begin(), next->second.end());
  chunks_.erase(next);
}

}  // namespace tims::core
