// Fixed blocks of memory for messages that must wait. The caller reserves the memory once; a block
// is touched when it is used for the first time, and the blocks used last are used again first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tims::core {

class BlockPool {
 public:
  static constexpr std::size_t kBlockSize = 4096;
  using Index = std::uint32_t;
  static constexpr Index kNone = 0xFFFFFFFF;

  // Aligned to kBlockSize; a rest that is no whole block is not used.
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

  // While no block is used: all count as never touched again, and the caller may give the memory
  // back to the system.
  void forget();

 private:
  std::byte* memory_;
  std::size_t capacity_;
  std::size_t used_ = 0;
  std::size_t touched_ = 0;  // blocks from here on were never used
  Index free_ = kNone;       // first of those that were; each holds the index of the next
};

}  // namespace tims::core
