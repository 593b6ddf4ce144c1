// What waits to be written to one router: datagrams in a ring of bytes, in the form they have in a
// sample (link/bundle.h), so that a sample is a piece of the ring.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "router/link/train.h"

namespace tims::io {

class SendQueue {
 public:
  static constexpr std::size_t kBytes = 4 << 20;  // allocated with the first train

  explicit SendQueue(std::size_t bytes = kBytes) : size_(bytes) {}

  // All of the train, or nothing: false when there is no room for it.
  bool put(const link::Train& train);

  // Whole datagrams from the front, `bytes_max` at most, or the first one if it is larger.
  struct Front {
    std::array<std::span<const std::byte>, 2> parts{};  // the second: from the ring's beginning on
    std::size_t bytes = 0;
    std::size_t datagrams = 0;
  };
  // It stays as it is until remove().
  [[nodiscard]] Front front(std::size_t bytes_max) const;
  void remove(const Front& front);

  [[nodiscard]] std::size_t waiting_bytes() const { return used_; }

 private:
  void write(std::span<const std::byte> bytes);
  [[nodiscard]] std::size_t datagram_size_at(std::size_t position) const;

  const std::size_t size_;
  std::unique_ptr<std::byte[]> ring_;
  std::size_t used_ = 0;
  std::size_t first_ = 0;  // the oldest byte
  std::size_t end_ = 0;    // where the next one goes
};

}  // namespace tims::io
