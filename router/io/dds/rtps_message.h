// Messages of RTPS 2.2 (8.3, 9.4) as bytes: as much of them as tells who one is from and for, what
// a participant announces (SPDP, 8.5.3), and what a heartbeat asks for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "router/link/transport.h"
#include "tims/time.h"

namespace tims::io {

struct RtpsMessage {
  // What a participant says of itself. An absent lease is the 100 s of the standard.
  struct Announced {
    std::span<const std::byte> user_data{};
    std::vector<link::NetAddress> metatraffic{};  // where it takes discovery; 8 at most, IPv4
    Duration lease = std::chrono::seconds(100);
  };

  link::DdsParticipant from{};
  std::optional<link::DdsParticipant> to{};  // for nobody else
  std::optional<Announced> announced{};
  bool ends = false;  // the participant says that it goes
};

// Nothing for bytes that are no RTPS message. Of one that is cut short, what can be read.
std::optional<RtpsMessage> parse_rtps(std::span<const std::byte> message);

// Who sent it, without a look at the rest.
std::optional<link::DdsParticipant> rtps_sender(std::span<const std::byte> message);

// What a reliable writer tells the readers of `to` it has; they answer with what they have got.
struct RtpsHeartbeat {
  link::DdsParticipant from{};
  std::array<std::uint8_t, 4> writer{};  // its entity id
  link::DdsParticipant to{};
  std::uint64_t first = 1;  // samples that can be sent again
  std::uint64_t last = 0;
  std::uint32_t count = 0;  // of heartbeats: readers take only growing ones
};
std::array<std::byte, 68> encode(const RtpsHeartbeat& heartbeat);

// The same message for one receiver alone. `message` is one that parse_rtps() knows.
std::vector<std::byte> directed(std::span<const std::byte> message, const link::DdsParticipant& to);

}  // namespace tims::io
