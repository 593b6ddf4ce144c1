#include "router/core/block_pool.h"

#include <algorithm>
#include <cstring>

namespace tims::core {

BlockPool::BlockPool(std::span<std::byte> memory)
    : memory_(memory.data()), capacity_(std::min<std::size_t>(memory.size() / kBlockSize, kNone)) {}

BlockPool::Index BlockPool::allocate() {
  if (used_ == capacity_) return kNone;
  ++used_;
  if (free_ == kNone) return static_cast<Index>(touched_++);
  const Index index = free_;
  std::memcpy(&free_, at(index), sizeof free_);
  return index;
}

void BlockPool::release(Index index) {
  std::memcpy(at(index), &free_, sizeof free_);
  free_ = index;
  --used_;
}

void BlockPool::forget() {
  touched_ = 0;
  free_ = kNone;
}

}  // namespace tims::core
