#include "router/core/table.h"

#include <utility>

namespace tims::core {
namespace {

constexpr std::size_t kCapacityMin = 64;

}  // namespace

Table::Table(HashSeed seed)
    : seed_{seed.first, seed.second | 1},  // a factor of 0 would map everything to 0
      mask_(kCapacityMin - 1),
      entries_(std::make_unique<Entry[]>(kCapacityMin)) {}

void Table::insert(const Entry& entry) {
  if ((size_ + 1) * 4 > (mask_ + 1) * 3) grow();
  place(entry);
  ++size_;
}

void Table::erase(const Entry* entry) {
  auto hole = static_cast<std::size_t>(entry - entries_.get());
  // An entry after the hole moves into it, unless it would then precede its home position.
  for (std::size_t i = (hole + 1) & mask_; entries_[i].owner; i = (i + 1) & mask_) {
    const std::size_t from_home = (i - home(entries_[i].address)) & mask_;
    const std::size_t from_hole = (i - hole) & mask_;
    if (from_home < from_hole) continue;
    entries_[hole] = entries_[i];
    hole = i;
  }
  entries_[hole] = Entry{};
  --size_;
}

void Table::place(const Entry& entry) {
  std::size_t i = home(entry.address);
  while (entries_[i].owner) i = (i + 1) & mask_;
  entries_[i] = entry;
}

void Table::grow() {
  const std::size_t old_capacity = mask_ + 1;
  mask_ = old_capacity * 2 - 1;
  const auto old = std::exchange(entries_, std::make_unique<Entry[]>(old_capacity * 2));
  for (std::size_t i = 0; i < old_capacity; ++i) {
    if (old[i].owner) place(old[i]);
  }
}

void AddressSet::insert(Address address) {
  auto at = std::prev(chunks_.upper_bound(address.raw()));
  if (at->second.size() == kChunkMax) {
    // Registration in ascending order leaves full arrays behind; any other order leaves halves.
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

// Prevents nearly empty arrays from accumulating.
void AddressSet::merge_with_next(Chunks::iterator at) {
  const auto next = std::next(at);
  if (next == chunks_.end() || at->second.size() + next->second.size() > kChunkMax / 2) return;
  at->second.insert(at->second.end(), next->second.begin(), next->second.end());
  chunks_.erase(next);
}

}  // namespace tims::core
