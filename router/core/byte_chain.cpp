#include "router/core/byte_chain.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace tims::core {
namespace {

constexpr BlockPool::Index kByteChainNone = BlockPool::kNone;

std::size_t room_behind(const ChainBlock& block) { return ByteChain::kBlockBytes - block.end; }

// Copies as much as fits; returns the rest.
std::span<const std::byte> fill(ChainBlock& block, std::span<const std::byte> bytes) {
  const std::size_t n = std::min(bytes.size(), room_behind(block));
  std::copy_n(bytes.begin(), n, block.data + block.end);
  block.end = static_cast<std::uint16_t>(block.end + n);
  return bytes.subspan(n);
}

}  // namespace

BlockPool::BlockPool(std::span<std::byte> memory)
    : memory_(memory.data()),
      capacity_(std::min<std::size_t>(memory.size() / kBlockSize, kByteChainNone)) {}

BlockPool::Index BlockPool::allocate() {
  if (used_ == capacity_) return kByteChainNone;
  ++used_;
  if (free_ == kByteChainNone) return static_cast<Index>(touched_++);
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
  free_ = kByteChainNone;
}

std::size_t ByteChain::blocks_needed(BlockPool& pool, std::size_t size) const {
  const std::size_t room = empty() ? 0 : room_behind(block(pool, tail));
  return size <= room ? 0 : (size - room + kBlockBytes - 1) / kBlockBytes;
}

void ByteChain::append(BlockPool& pool, std::span<const std::byte> bytes) {
  if (!empty()) bytes = fill(block(pool, tail), bytes);
  while (!bytes.empty()) {
    const BlockPool::Index index = pool.allocate();
    ChainBlock& fresh = block(pool, index);
    fresh.begin = fresh.end = 0;
    link(pool, index);
    bytes = fill(fresh, bytes);
  }
}

void ByteChain::peek(BlockPool& pool, std::span<std::byte> to) const {
  for (BlockPool::Index i = head; !to.empty(); i = block(pool, i).next) {
    const auto bytes = block(pool, i).bytes();
    const std::size_t n = std::min(bytes.size(), to.size());
    std::copy_n(bytes.begin(), n, to.begin());
    to = to.subspan(n);
  }
}

void ByteChain::drop(BlockPool& pool, std::size_t size) {
  while (size > 0) {
    ChainBlock& first = block(pool, head);
    const std::size_t n = std::min(size, first.bytes().size());
    first.begin = static_cast<std::uint16_t>(first.begin + n);
    size -= n;
    if (first.bytes().empty()) pool.release(unlink_head(pool));
  }
}

void ByteChain::clear(BlockPool& pool) {
  while (!empty()) pool.release(unlink_head(pool));
}

void ByteChain::move_front(BlockPool& pool, std::size_t size, ByteChain& to,
                           BlockPool::Index& spare) {
  while (size > 0 && block(pool, head).bytes().size() <= size) {
    size -= block(pool, head).bytes().size();
    to.link(pool, unlink_head(pool));
  }
  if (size == 0) return;
  const BlockPool::Index rest = std::exchange(spare, kByteChainNone);
  ChainBlock& own = block(pool, rest);
  own.begin = own.end = 0;
  fill(own, block(pool, head).bytes().first(size));
  to.link(pool, rest);
  drop(pool, size);
}

ByteChain::Place ByteChain::front(BlockPool& pool) const {
  if (empty()) return {};
  return {.block = head, .offset = block(pool, head).begin};
}

ByteChain::Place ByteChain::advanced(BlockPool& pool, Place place, std::size_t size) {
  while (size > 0) {
    const ChainBlock& at = block(pool, place.block);
    const std::size_t n = std::min<std::size_t>(size, at.end - place.offset);
    place.offset = static_cast<std::uint16_t>(place.offset + n);
    size -= n;
    if (place.offset < at.end) break;
    place = {at.next, place.block, 0};
    if (place.block != kByteChainNone) place.offset = block(pool, place.block).begin;
  }
  return place;
}

void ByteChain::peek(BlockPool& pool, const Place& place, std::span<std::byte> to) {
  std::size_t offset = place.offset;
  for (BlockPool::Index i = place.block; !to.empty(); i = block(pool, i).next) {
    const ChainBlock& at = block(pool, i);
    if (i != place.block) offset = at.begin;
    const std::size_t n = std::min<std::size_t>(at.end - offset, to.size());
    std::copy_n(at.data + offset, n, to.begin());
    to = to.subspan(n);
  }
}

void ByteChain::replace(BlockPool& pool, const Place& place, std::size_t size,
                        std::span<const std::byte> bytes) {
  ByteChain behind = cut(pool, place);
  behind.drop(pool, size);
  append(pool, bytes);
  if (behind.empty()) return;
  (empty() ? head : block(pool, tail).next) = behind.head;
  tail = behind.tail;
}

// Removes everything from `place` on, and returns it. A block in the middle of which this is gets
// a second one.
ByteChain ByteChain::cut(BlockPool& pool, const Place& place) {
  ChainBlock& first = block(pool, place.block);
  ByteChain behind{place.block, tail};
  if (place.offset == first.begin) {
    tail = place.previous;
    (tail == kByteChainNone ? head : block(pool, tail).next) = kByteChainNone;
    return behind;
  }
  behind.head = pool.allocate();
  if (place.block == tail) behind.tail = behind.head;
  ChainBlock& second = block(pool, behind.head);
  second.begin = second.end = 0;
  second.next = first.next;
  fill(second,
       std::span<const std::byte>(first.data).subspan(place.offset, first.end - place.offset));
  first.end = place.offset;
  first.next = kByteChainNone;
  tail = place.block;
  return behind;
}

std::size_t ByteChain::gather(BlockPool& pool, std::span<std::span<const std::byte>> pieces,
                              std::size_t count) const {
  for (BlockPool::Index i = head; i != kByteChainNone && count < pieces.size();
       i = block(pool, i).next) {
    pieces[count++] = block(pool, i).bytes();
  }
  return count;
}

ChainBlock& ByteChain::block(BlockPool& pool, BlockPool::Index index) {
  return *reinterpret_cast<ChainBlock*>(pool.at(index));
}

void ByteChain::link(BlockPool& pool, BlockPool::Index index) {
  block(pool, index).next = kByteChainNone;
  if (empty()) {
    head = index;
  } else {
    block(pool, tail).next = index;
  }
  tail = index;
}

BlockPool::Index ByteChain::unlink_head(BlockPool& pool) {
  const BlockPool::Index index = head;
  head = block(pool, index).next;
  if (head == kByteChainNone) tail = kByteChainNone;
  return index;
}

}  // namespace tims::core
