#include "router/core/table.h"

#include <utility>

namespace tims::core {
namespace {

constexpr std::size_t kCapacityMin = 64;

// Product of two 64-bit numbers, its halves folded together.
std::uint64_t fold(std::uint64_t a, std::uint64_t b) {
  __extension__ using Wide = unsigned __int128;
  const Wide product = Wide{a} * b;
  return static_cast<std::uint64_t>(product) ^ static_cast<std::uint64_t>(product >> 64);
}

}  // namespace

Table::Table(HashSeed seed)
    : seed_{seed.first, seed.second | 1},  // a factor of 0 would fold everything to 0
      mask_(kCapacityMin - 1),
      entries_(std::make_unique<Entry[]>(kCapacityMin)) {}

const Table::Entry* Table::find(Address address) const {
  for (std::size_t i = home(address);; i = (i + 1) & mask_) {
    const Entry& entry = entries_[i];
    if (!entry.owner) return nullptr;
    if (entry.address == address) return &entry;
  }
}

void Table::insert(const Entry& entry) {
  if ((size_ + 1) * 4 > (mask_ + 1) * 3) grow();
  place(entry);
  ++size_;
}

void Table::erase(const Entry* entry) {
  auto hole = static_cast<std::size_t>(entry - entries_.get());
  // An entry behind the hole moves into it unless it would then stand before its home.
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

std::size_t Table::home(Address address) const {
  const std::uint64_t once = fold(address.raw() ^ seed_.first, seed_.second);
  return static_cast<std::size_t>(fold(once ^ seed_.second, 0x9E3779B97F4A7C15ULL)) & mask_;
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

}  // namespace tims::core
