// Puts IP datagrams together that were sent in fragments, as large UDP packets of scanners are.
// Bounded: a datagram has at most 64 KiB, and the oldest incomplete one is given up.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

namespace rack::device {

class DatagramAssembly {
 public:
  static constexpr std::size_t kOpenMax = 64;
  static constexpr std::size_t kBytesMax = 65535;

  // Identifies the datagram that a fragment belongs to.
  struct Key {
    std::array<std::byte, 32> addresses{};  // of sender and receiver
    std::uint32_t id = 0;
    std::uint32_t protocol = 0;

    bool operator==(const Key&) const = default;
  };
  struct Fragment {
    Key key{};
    std::size_t offset = 0;  // a multiple of 8
    bool is_last = false;
    std::span<const std::byte> bytes{};
  };

  // Returns the datagram if this fragment completes it; valid until the next call.
  std::optional<std::span<const std::byte>> add(const Fragment& fragment);

  // Number of fragments of datagrams that are not complete.
  [[nodiscard]] std::uint64_t incomplete() const;

 private:
  static constexpr std::size_t kUnit = 8;  // bytes; offsets of fragments are multiples of it

  struct Open {
    Key key{};
    std::vector<std::byte> bytes{};
    std::vector<bool> has_unit{};
    std::optional<std::size_t> size{};
    std::uint64_t fragments = 0;
  };

  Open& open(const Key& key);
  static bool put(Open& datagram, const Fragment& fragment);

  std::deque<Open> open_;
  std::vector<std::byte> complete_;
  std::uint64_t given_up_ = 0;
};

}  // namespace rack::device
