// Which of the other side's packets have come: throws out what comes twice, and says what is to be
// acknowledged. Remembers the newest kWindow numbers; what is older counts as come twice.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "router/link/frame.h"

namespace tims::link {

class PacketWindow {
 public:
  static constexpr std::uint64_t kWindow = 4096;

  // The whole number behind the 32 bits on the wire: the one nearest to what is expected next.
  [[nodiscard]] std::uint64_t expand(std::uint32_t wire) const;

  [[nodiscard]] bool is_new(std::uint64_t packet) const;
  void add(std::uint64_t packet);  // it is new

  [[nodiscard]] std::uint64_t next() const { return next_; }  // one above the newest
  // The newest ranges; nothing while no packet has come.
  void fill(Ack& ack) const;

 private:
  [[nodiscard]] std::uint64_t below(std::uint64_t packet, bool come) const;
  [[nodiscard]] bool seen(std::uint64_t packet) const {
    return (bits_[packet % kWindow / 64] >> (packet % 64) & 1) != 0;
  }

  std::uint64_t next_ = 0;
  std::array<std::uint64_t, kWindow / 64> bits_{};
};

}  // namespace tims::link
