// Memory for waiting messages: streams of bytes (ByteChain) in blocks of a shared pool
// (BlockPool).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tims::core {

// Fixed-size blocks for waiting messages. The caller reserves the memory once; a block is first
// touched when it is first used, and the most recently freed blocks are reused first.
class BlockPool {
 public:
  static constexpr std::size_t kBlockSize = 4096;
  using Index = std::uint32_t;
  static constexpr Index kNone = 0xFFFFFFFF;

  // Aligned to kBlockSize; a remainder smaller than a block is not used.
  explicit BlockPool(std::span<std::byte> memory);
  BlockPool(const BlockPool&) = delete;
  BlockPool& operator=(const BlockPool&) = delete;

  [[nodiscard]] Index allocate();  // kNone when all are in use
  void release(Index index);

  [[nodiscard]] std::byte* at(Index index) { return memory_ + std::size_t{index} * kBlockSize; }
  [[nodiscard]] const std::byte* at(Index index) const {
    return memory_ + std::size_t{index} * kBlockSize;
  }

  [[nodiscard]] std::size_t available() const { return capacity_ - used_; }
  [[nodiscard]] std::size_t used() const { return used_; }

  [[nodiscard]] std::size_t touched_bytes() const { return touched_ * kBlockSize; }

  // Precondition: no block is in use. Marks all blocks as never touched, so that the caller may
  // return the memory to the system.
  void forget();

 private:
  std::byte* memory_;
  std::size_t capacity_;
  std::size_t used_ = 0;
  std::size_t touched_ = 0;  // blocks from here on were never used
  Index free_ = kNone;       // first free block among those; each holds the index of the next
};

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

// A first-in first-out stream of bytes in blocks of a pool. Trivially copyable, so that it can
// itself be stored in a block; the pool is passed to every call.
struct ByteChain {
  static constexpr std::size_t kBlockBytes = sizeof(ChainBlock::data);

  BlockPool::Index head = BlockPool::kNone;
  BlockPool::Index tail = BlockPool::kNone;

  [[nodiscard]] bool empty() const { return head == BlockPool::kNone; }

  // New blocks that append() of `size` bytes would take.
  [[nodiscard]] std::size_t blocks_needed(BlockPool& pool, std::size_t size) const;
  // Precondition: the pool has that many blocks.
  void append(BlockPool& pool, std::span<const std::byte> bytes);

  // Copies the first bytes without removing them. Precondition: the chain has as many.
  void peek(BlockPool& pool, std::span<std::byte> to) const;
  // Removes the first `size` bytes. Precondition: the chain has as many.
  void drop(BlockPool& pool, std::size_t size);
  void clear(BlockPool& pool);

  // Moves the first `size` bytes to the end of `to`, of which only the part in a block shared with
  // later bytes is copied: into `spare`, which is kNone afterwards if it was needed.
  void move_front(BlockPool& pool, std::size_t size, ByteChain& to, BlockPool::Index& spare);

  // A position within the chain. Invalid after any change.
  struct Place {
    BlockPool::Index block = BlockPool::kNone;  // kNone: the end
    BlockPool::Index previous = BlockPool::kNone;
    std::uint16_t offset = 0;  // in the block's data
  };
  [[nodiscard]] Place front(BlockPool& pool) const;
  // The position `size` bytes further. Precondition: the chain has as many behind `place`.
  static Place advanced(BlockPool& pool, Place place, std::size_t size);
  // Copies bytes without removing them. Precondition: there are as many behind `place`.
  static void peek(BlockPool& pool, const Place& place, std::span<std::byte> to);

  // Blocks that replace() by `size` bytes takes at most.
  static constexpr std::size_t replace_blocks_max(std::size_t size) {
    return size / kBlockBytes + 2;
  }
  // Exchanges `size` bytes at `place` for others, of any number. Preconditions: the chain has as
  // many behind `place`, and the pool has replace_blocks_max() blocks.
  void replace(BlockPool& pool, const Place& place, std::size_t size,
               std::span<const std::byte> bytes);

  // Fills `pieces` from index `count` on with the contents of the chain, front to back. Returns
  // the new count.
  std::size_t gather(BlockPool& pool, std::span<std::span<const std::byte>> pieces,
                     std::size_t count) const;

 private:
  static ChainBlock& block(BlockPool& pool, BlockPool::Index index);
  void link(BlockPool& pool, BlockPool::Index index);
  BlockPool::Index unlink_head(BlockPool& pool);
  ByteChain cut(BlockPool& pool, const Place& place);
};

}  // namespace tims::core
