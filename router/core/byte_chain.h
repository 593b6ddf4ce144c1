// A first-in first-out stream of bytes in blocks of a pool.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "router/core/block_pool.h"

namespace tims::core {

// A block of a chain: bytes [begin, end) of its data are in use.
struct ChainBlock {
  BlockPool::Index next;
  std::uint16_t begin;
  std::uint16_t end;
  std::byte data[BlockPool::kBlockSize - 8];

  [[nodiscard]] std::span<const std::byte> bytes() const {
    return {data + begin, static_cast<std::size_t>(end - begin)};
  }
};
static_assert(sizeof(ChainBlock) == BlockPool::kBlockSize);

// Plain data, so that it may itself lie in a block; the pool is handed to every call.
struct ByteChain {
  static constexpr std::size_t kBlockBytes = sizeof(ChainBlock::data);

  BlockPool::Index head = BlockPool::kNone;
  BlockPool::Index tail = BlockPool::kNone;

  [[nodiscard]] bool empty() const { return head == BlockPool::kNone; }

  // New blocks that append() of `size` bytes would take.
  [[nodiscard]] std::size_t blocks_needed(BlockPool& pool, std::size_t size) const;
  // The pool has that many.
  void append(BlockPool& pool, std::span<const std::byte> bytes);

  // Copies the first bytes without taking them; the chain has as many.
  void peek(BlockPool& pool, std::span<std::byte> to) const;
  // Takes the first `size` bytes away; the chain has as many.
  void drop(BlockPool& pool, std::size_t size);
  void clear(BlockPool& pool);

  // Moves the first `size` bytes to the end of `to`, of which only the part in a block shared with
  // later bytes is copied: into `spare`, which is kNone afterwards if it was needed.
  void move_front(BlockPool& pool, std::size_t size, ByteChain& to, BlockPool::Index& spare);

  // Fills `pieces` from `count` on with what is in the chain, front to back. Returns the new count.
  std::size_t gather(BlockPool& pool, std::span<std::span<const std::byte>> pieces,
                     std::size_t count) const;

 private:
  static ChainBlock& block(BlockPool& pool, BlockPool::Index index);
  void link(BlockPool& pool, BlockPool::Index index);
  BlockPool::Index unlink_head(BlockPool& pool);
};

}  // namespace tims::core
