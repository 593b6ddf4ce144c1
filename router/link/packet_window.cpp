#include "router/link/packet_window.h"

#include <algorithm>

namespace tims::link {

std::uint64_t PacketWindow::expand(std::uint32_t wire) const {
  constexpr std::uint64_t kTurn = std::uint64_t{1} << 32;
  constexpr std::uint64_t kHalf = kTurn / 2;
  const std::uint64_t near = (next_ & ~(kTurn - 1)) | wire;
  if (near + kHalf <= next_) return near + kTurn;
  if (near > next_ + kHalf && near >= kTurn) return near - kTurn;
  return near;
}

bool PacketWindow::is_new(std::uint64_t packet) const {
  if (packet >= next_) return true;
  return packet + kWindow >= next_ && !seen(packet);
}

void PacketWindow::add(std::uint64_t packet) {
  if (packet >= next_) {
    // What lies between has not come; a leap beyond the window forgets everything.
    const std::uint64_t forget = std::min(packet + 1 - next_, kWindow);
    for (std::uint64_t i = packet + 1 - forget; i <= packet; ++i) {
      bits_[i % kWindow / 64] &= ~(std::uint64_t{1} << (i % 64));
    }
    next_ = packet + 1;
  }
  bits_[packet % kWindow / 64] |= std::uint64_t{1} << (packet % 64);
}

void PacketWindow::fill(Ack& ack) const {
  ack.count = 0;
  const std::uint64_t oldest = next_ - std::min(next_, kWindow);
  std::uint64_t at = next_;
  while (at > oldest && ack.count < Ack::kRangesMax) {
    while (at > oldest && !seen(at - 1)) {
      // Whole words of missing ones at once.
      at -= at % 64 == 0 && at - oldest >= 64 && bits_[(at - 1) % kWindow / 64] == 0 ? 64 : 1;
    }
    if (at == oldest) break;
    const std::uint64_t last = at - 1;
    while (at > oldest && seen(at - 1)) {
      at -= at % 64 == 0 && at - oldest >= 64 && ~bits_[(at - 1) % kWindow / 64] == 0 ? 64 : 1;
    }
    ack.ranges[ack.count++] = {static_cast<std::uint32_t>(at), static_cast<std::uint32_t>(last)};
  }
}

}  // namespace tims::link
