#include "router/core/table.h"

#include <utility>

namespace tims::core {
namespace {

constexpr std::size_t kCapacityMin = 64;

}  // namespace

Table::Table(HashSeed seed)
    : seed_{seed.first, seed.second | 1},  // a factor of 0 would fold everything to 0
      mask_(kCapacityMin - 1),
      entries_(std::make_unique<Entry[]>(kCapacityMin)) {}

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
