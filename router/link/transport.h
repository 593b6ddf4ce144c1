// Types exchanged between links and the sockets below them: the address of a datagram
// (NetAddress), several datagrams for one system call (Burst), several in one DDS sample (Batch).
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

// The first bytes of a DDS participant's GUID, which are unique to it.
using DdsParticipant = std::array<std::uint8_t, 12>;

// IPv4 addresses are stored in their IPv6 form ::ffff:a.b.c.d, so that all addresses have one
// form. For a DDS participant, `ip` begins with the GUID prefix.
struct NetAddress {
  std::array<std::uint8_t, 16> ip{};  // network order
  std::uint16_t port = 0;             // 0: no address
  std::uint32_t scope = 0;            // interface of a link-local IPv6 address
  PathKind kind = PathKind::kUdp;

  explicit operator bool() const { return port != 0; }
  [[nodiscard]] bool is_v4() const;
  // "10.9.1.1:2010", "[fe80::1%3]:2010", "dds:010f6e1f0a00000001000000", "tcp:10.9.1.1:2010"
  [[nodiscard]] std::string to_string() const;
  [[nodiscard]] DdsParticipant participant() const;  // for a DDS address

  static NetAddress v4(std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d,
                       std::uint16_t port);
  static NetAddress dds(const DdsParticipant& participant);

  auto operator<=>(const NetAddress&) const = default;
};

inline constexpr std::size_t kBurstBytesMax = 65'000;  // maximum for one system call
inline constexpr std::size_t kBurstDatagramsMax = 64;

// Bytes a datagram costs on the link in addition to its payload: Ethernet, IPv4 and UDP headers.
inline constexpr std::size_t kDatagramOverhead = 42;

// Outgoing datagrams of equal size to one address, which a path passes to the system in one call
// (UDP_SEGMENT).
struct Burst {
  NetAddress to{};
  std::span<const std::byte> bytes{};  // all datagrams, concatenated
  std::size_t datagram_size = 0;       // of all but the last, which may be shorter
  std::uint8_t dscp = 0;               // 6 bits, of the most urgent class contained

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

// Sends bursts over one kind of path: a socket, DDS, or a simulated network.
class DatagramSender : public core::Interface {
 public:
  // Returns false when it cannot accept the burst now; the same burst is offered again later.
  virtual bool offer(const Burst& burst) = 0;
};

inline constexpr std::size_t kBatchSizeBytes = 2;   // size field before each datagram
inline constexpr std::size_t kBatchedMax = 0xFFFF;  // maximum size of one datagram

// Several datagrams as one sample of a DDS topic: each preceded by its size in two bytes. A
// sample with many small datagrams costs the same as a sample with one.
//
// The bytes are untrusted input: call valid() first, which checks all of them.
class Batch {
 public:
  explicit Batch(std::span<std::byte> bytes) : bytes_(bytes) {}

  // At least one datagram, none empty, and nothing after the last one except the zeros that pad a
  // sample to a multiple of four bytes.
  [[nodiscard]] bool valid() const;

  // Calls visit(std::span<std::byte> datagram) for each datagram of a valid batch.
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
