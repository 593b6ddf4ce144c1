#include "router/link/stream_buffer.h"

#include <algorithm>
#include <cstring>

namespace tims::link {

bool StreamBuffer::has_room(std::size_t size) const {
  const std::uint64_t free_in_last = base_ + count_ * kBlock - end_;
  if (size <= free_in_last) return true;
  return (size - free_in_last + kBlock - 1) / kBlock <= pool_.available();
}

void StreamBuffer::add_block() {
  if (count_ == ring_.size()) {
    std::vector<core::BlockPool::Index> larger(std::max<std::size_t>(4, 2 * ring_.size()));
    for (std::size_t i = 0; i < count_; ++i) larger[i] = slot(i);
    ring_ = std::move(larger);
    first_ = 0;
  }
  slot(count_) = pool_.allocate();
  ++count_;
}

void StreamBuffer::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const std::size_t size = std::min(kBlock - (offset - base_) % kBlock, bytes.size());
    std::memcpy(at(offset), bytes.data(), size);
    offset += size;
    bytes = bytes.subspan(size);
  }
}

void StreamBuffer::move_front(std::size_t size, StreamBuffer& to) {
  while (size > 0) {
    const std::size_t piece = std::min(kBlock - (begin_ - base_) % kBlock, size);
    to.append({at(begin_), piece});
    release_to(begin_ + piece);
    size -= piece;
  }
}

void StreamBuffer::release_to(std::uint64_t offset) {
  begin_ = offset;
  while (count_ > 0 && (base_ + kBlock <= begin_ || begin_ == end_)) {
    pool_.release(slot(0));
    first_ = (first_ + 1) & (ring_.size() - 1);
    --count_;
    base_ += kBlock;
  }
  if (count_ == 0) base_ = begin_;
}

void StreamBuffer::reset(std::uint64_t offset) {
  release_to(end_);
  base_ = begin_ = end_ = offset;
}

}  // namespace tims::link
