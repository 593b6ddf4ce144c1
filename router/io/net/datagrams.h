// What arrives at a UDP socket: up to 16 slots in one call, each with many datagrams of one sender
// where the kernel puts them together (UDP_GRO). The memory is allocated once.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "router/link/net_address.h"

namespace tims::io {

class Datagrams {
 public:
  static constexpr std::size_t kSlots = 16;
  static constexpr std::size_t kSlotBytes = 64 << 10;  // the most that the kernel puts together

  struct Slot {
    link::NetAddress from{};
    std::span<std::byte> bytes{};   // datagrams, one behind the other; empty: one without content
    std::size_t datagram_size = 0;  // of each but the last, which may be shorter
  };

  // Smaller slots are for tests.
  explicit Datagrams(std::size_t slot_bytes = kSlotBytes);
  Datagrams(const Datagrams&) = delete;
  Datagrams& operator=(const Datagrams&) = delete;
  ~Datagrams();

  // Of the last receive(), until the next one. The bytes may be written to (decryption in place).
  [[nodiscard]] std::span<const Slot> slots() const { return {slots_.get(), count_}; }

  // visit(const link::NetAddress& from, std::span<std::byte> datagram)
  template <typename Visit>
  void for_each_datagram(Visit&& visit) const;

 private:
  friend class UdpSocket;

  struct Calls;  // what recvmmsg() takes
  struct Outcome {
    std::size_t messages = 0;   // slots that were filled by the call
    std::size_t truncated = 0;  // of them: larger than a slot, or without sender; left out here
    std::optional<std::uint32_t> dropped_by_kernel{};  // since the socket was opened
  };
  Outcome receive(int socket);
  void prepare();
  void take(std::size_t index, Outcome& outcome);

  struct Release {
    void operator()(std::byte* pages) const;
  };
  std::size_t slot_bytes_;
  std::unique_ptr<std::byte, Release> pages_;
  std::unique_ptr<Calls> calls_;
  std::unique_ptr<Slot[]> slots_;
  std::size_t count_ = 0;
  std::size_t used_ = kSlots;  // by the last call
};

template <typename Visit>
void Datagrams::for_each_datagram(Visit&& visit) const {
  for (const Slot& slot : slots()) {
    std::span<std::byte> rest = slot.bytes;
    do {
      const std::size_t size = std::min(slot.datagram_size, rest.size());
      visit(slot.from, rest.first(size));
      rest = rest.subspan(size);
    } while (!rest.empty());
  }
}

}  // namespace tims::io
