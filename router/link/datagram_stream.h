// Datagrams on a stream of bytes, as TCP carries them: each preceded by its size in two bytes, like
// those of a Batch. Either they come in whole, or they are put together here.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace tims::link {

class DatagramStream {
 public:
  static constexpr std::size_t kSizeBytes = 2;

  // Precondition: 1 to kDatagramMax bytes.
  static void put(std::span<const std::byte> datagram, std::vector<std::byte>& out);

  // Calls visit(std::span<std::byte> datagram) for each one that these bytes complete. Each stays
  // valid as long as `bytes` do, but not beyond the next call or this object's end: what receives
  // it may keep it until the turn is flushed. False: a size that no datagram has; nothing that
  // follows can be understood, so end the connection.
  template <typename Visit>
  bool feed(std::span<std::byte> bytes, Visit&& visit) {
    for (auto datagram = next(bytes); !datagram.empty(); datagram = next(bytes)) visit(datagram);
    return !is_broken_;
  }

 private:
  std::span<std::byte> next(std::span<std::byte>& bytes);
  // With its size field; 0: not known yet.
  [[nodiscard]] std::size_t whole_size(std::span<const std::byte> begin);

  std::vector<std::byte> part_;    // the beginning of one, at most kSizeBytes + kDatagramMax
  std::vector<std::byte> passed_;  // the newest one that was put together here, with its size
  bool is_broken_ = false;
};

}  // namespace tims::link
