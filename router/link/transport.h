// What links and the sockets under them hand each other: where a datagram comes from or goes to
// (NetAddress), several for one call of the system (Burst), several as one sample of DDS (Batch).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "router/core/types.h"

namespace tims::link {

using core::PathKind;

// The first bytes of a DDS participant's GUID, which no other participant has.
using DdsParticipant = std::array<std::uint8_t, 12>;

// IPv4 addresses stand in their IPv6 form ::ffff:a.b.c.d, so that all are one kind of key. Of a DDS
// participant, `ip` begins with the GUID prefix.
struct NetAddress {
  std::array<std::uint8_t, 16> ip{};  // network order
  std::uint16_t port = 0;             // 0: no address
  std::uint32_t scope = 0;            // interface of a link-local IPv6 address
  PathKind kind = PathKind::kUdp;

  explicit operator bool() const { return port != 0; }
  [[nodiscard]] bool is_v4() const;
  // "10.9.1.1:2010", "[fe80::1%3]:2010", "dds:010f6e1f0a00000001000000"
  [[nodiscard]] std::string to_string() const;
  [[nodiscard]] DdsParticipant participant() const;  // of a DDS address

  static NetAddress v4(std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d,
                       std::uint16_t port);
  static NetAddress dds(const DdsParticipant& participant);

  auto operator<=>(const NetAddress&) const = default;
};

inline constexpr std::size_t kBurstBytesMax = 65'000;  // what the kernel takes in one call
inline constexpr std::size_t kBurstDatagramsMax = 64;

// What a datagram costs a link beside its bytes: Ethernet, IPv4 and UDP.
inline constexpr std::size_t kDatagramOverhead = 42;

// Datagrams on their way out: several of one size to one address, which a path hands to the system
// in one call (UDP_SEGMENT).
struct Burst {
  NetAddress to{};
  std::span<const std::byte> bytes{};  // all datagrams, one behind the other
  std::size_t datagram_size = 0;       // of each but the last, which may be shorter
  std::uint8_t dscp = 0;               // 6 bits, from the most urgent class in it

  [[nodiscard]] std::size_t count() const {
    return datagram_size == 0 ? 0 : (bytes.size() + datagram_size - 1) / datagram_size;
  }
  template <typename Visit>  // (std::span<const std::byte> datagram)
  void for_each(Visit visit) const {
    for (std::span<const std::byte> rest = bytes; !rest.empty();) {
      const auto datagram = rest.first(std::min(datagram_size, rest.size()));
      rest = rest.subspan(datagram.size());
      visit(datagram);
    }
  }
};

// What carries bursts over one kind of path: a socket, DDS, or a simulated network.
class DatagramSender : public core::Interface {
 public:
  // False: it takes nothing now, and the same burst is offered again later.
  virtual bool offer(const Burst& burst) = 0;
};

inline constexpr std::size_t kBatchSizeBytes = 2;   // before each datagram
inline constexpr std::size_t kBatchedMax = 0xFFFF;  // bytes of one datagram

// Several datagrams as one sample of a DDS topic: each behind its size, two bytes. So many small
// ones cost what one costs.
//
// Bytes that somebody else wrote: valid() looks at all of them, first.
class Batch {
 public:
  explicit Batch(std::span<std::byte> bytes) : bytes_(bytes) {}

  // At least one datagram, none of them empty, and nothing behind the last one but the zeros that
  // make a sample a multiple of four bytes.
  [[nodiscard]] bool valid() const;

  // visit(std::span<std::byte> datagram), of a valid one.
  template <typename Visit>
  void for_each(Visit&& visit) const {
    for (std::size_t at = 0; at + kBatchSizeBytes <= bytes_.size();) {
      const std::size_t size = size_at(bytes_, at);
      if (size == 0) return;
      visit(bytes_.subspan(at + kBatchSizeBytes, size));
      at += kBatchSizeBytes + size;
    }
  }

  static std::size_t size_at(std::span<const std::byte> bytes, std::size_t at) {
    return std::to_integer<std::size_t>(bytes[at]) | std::to_integer<std::size_t>(bytes[at + 1])
                                                         << 8;
  }

 private:
  std::span<std::byte> bytes_;
};

}  // namespace tims::link
