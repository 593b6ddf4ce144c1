#include "router/link/packet_window.h"

#include <algorithm>
#include <bit>

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
  std::uint64_t at = next_;
  while (ack.count < Ack::kRangesMax) {
    const std::uint64_t end = below(at, false);
    at = below(end, true);
    if (at == end) return;
    ack.ranges[ack.count++] = {static_cast<std::uint32_t>(at), static_cast<std::uint32_t>(end - 1)};
  }
}

// The end of the run below `packet` in which all have come, or none has. A word at a time.
std::uint64_t PacketWindow::below(std::uint64_t packet, bool come) const {
  const std::uint64_t oldest = next_ - std::min(next_, kWindow);
  while (packet > oldest) {
    const std::uint64_t bits = bits_[(packet - 1) % kWindow / 64];
    const std::uint64_t in_word = (packet - 1) % 64 + 1;
    const auto run =
        static_cast<std::uint64_t>(std::countl_one((come ? bits : ~bits) << (64 - in_word)));
    packet -= std::min({run, in_word, packet - oldest});
    if (run < in_word) break;
  }
  return packet;
}

}  // namespace tims::link
