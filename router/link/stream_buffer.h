// Bytes of a lane between two offsets: appended at the end, released at the front, read anywhere.
// They lie in blocks of a shared pool; a ring of block numbers leads to each with one look.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "router/core/byte_chain.h"

namespace tims::link {

class StreamBuffer {
 public:
  explicit StreamBuffer(core::BlockPool& pool) : pool_(pool) {}
  StreamBuffer(const StreamBuffer&) = delete;
  StreamBuffer& operator=(const StreamBuffer&) = delete;
  ~StreamBuffer() { release_to(end_); }

  [[nodiscard]] std::uint64_t begin() const { return begin_; }
  [[nodiscard]] std::uint64_t end() const { return end_; }
  [[nodiscard]] std::uint64_t size() const { return end_ - begin_; }
  [[nodiscard]] bool empty() const { return begin_ == end_; }

  // Has the pool enough blocks to append as much?
  [[nodiscard]] bool has_room(std::size_t size) const;
  void append(std::span<const std::byte> bytes) {  // has_room()
    while (!bytes.empty()) {
      if (end_ == base_ + count_ * kBlock) add_block();
      const std::size_t size = std::min(kBlock - (end_ - base_) % kBlock, bytes.size());
      std::memcpy(at(end_), bytes.data(), size);
      end_ += size;
      bytes = bytes.subspan(size);
    }
  }

  // Copies what lies from `offset` on; all of it is here.
  void read(std::uint64_t offset, std::span<std::byte> to) const {
    while (!to.empty()) {
      const std::size_t size = std::min(kBlock - (offset - base_) % kBlock, to.size());
      std::memcpy(to.data(), at(offset), size);
      offset += size;
      to = to.subspan(size);
    }
  }
  // Overwrites what lies from `offset` on; all of it is here.
  void write(std::uint64_t offset, std::span<const std::byte> bytes);
  // Moves the first `size` bytes to the end of another buffer, which has room for them.
  void move_front(std::size_t size, StreamBuffer& to);

  void release_to(std::uint64_t offset);
  // Empty, and the next byte has this offset.
  void reset(std::uint64_t offset);

 private:
  static constexpr std::size_t kBlock = core::BlockPool::kBlockSize;

  [[nodiscard]] std::byte* at(std::uint64_t offset) const {
    const std::uint64_t i = (offset - base_) / kBlock;
    return pool_.at(ring_[(first_ + i) & (ring_.size() - 1)]) + (offset - base_) % kBlock;
  }
  [[nodiscard]] core::BlockPool::Index& slot(std::size_t i) {
    return ring_[(first_ + i) & (ring_.size() - 1)];
  }
  void add_block();

  core::BlockPool& pool_;
  std::vector<core::BlockPool::Index> ring_;  // a power of two, or empty
  std::size_t first_ = 0;                     // where the first block stands in ring_
  std::size_t count_ = 0;
  std::uint64_t base_ = 0;  // offset of the first block's first byte
  std::uint64_t begin_ = 0;
  std::uint64_t end_ = 0;
};

}  // namespace tims::link
