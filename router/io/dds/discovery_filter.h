// Decides which participants our own library discovers. Fast DDS creates endpoints for every
// participant it discovers, and announces itself again to each: n routers that start at the same
// time exchange some twenty messages for each of n * n pairs. A router needs only those it has
// links with. So announcements are read and kept here, and the library receives one when either
// side wants to communicate:
//
//     held ── admit(): we send to it; or it addresses us ──► admitted ── forget() ──► held again
//
// Until then all other messages of a participant are dropped, as are those of participants that
// are not routers of our fleet. Of the participants that address us, a few per second are
// admitted; the others retry within a second.
//
// Only a part of RTPS 2.2 (8.3, 9.4) is decoded: sender and receiver of a message, the
// announcement of a participant (SPDP, 8.5.3), and the contents of a heartbeat.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "base/rate_limiter.h"
#include "router/link/datagram.h"
#include "router/link/fleet.h"
#include "router/link/transport.h"
#include "tims/time.h"

namespace tims::io {

// --- messages

struct RtpsMessage {
  // The announcement of a participant. An absent lease has the standard's default of 100 s.
  struct Announced {
    std::span<const std::byte> user_data{};
    std::vector<link::NetAddress> metatraffic{};  // addresses for discovery; at most 8, IPv4
    Duration lease = std::chrono::seconds(100);
  };

  link::DdsParticipant from{};
  std::optional<link::DdsParticipant> to{};  // the only intended receiver
  std::optional<Announced> announced{};
  bool ends = false;  // the participant announces its end
};

// Empty for bytes that are not an RTPS message. For a truncated message, the readable part.
std::optional<RtpsMessage> parse_rtps(std::span<const std::byte> bytes);

// The sender, without decoding the rest.
std::optional<link::DdsParticipant> rtps_sender(std::span<const std::byte> bytes);

// The range of samples a reliable writer offers to the readers of `to`; they answer with an
// acknowledgement.
struct RtpsHeartbeat {
  link::DdsParticipant from{};
  std::array<std::uint8_t, 4> writer{};  // its entity id
  link::DdsParticipant to{};
  std::uint64_t first = 1;  // oldest sample that can be sent again
  std::uint64_t last = 0;
  std::uint32_t count = 0;  // number of the heartbeat: readers accept only increasing ones
};
std::array<std::byte, 68> encode(const RtpsHeartbeat& heartbeat);

// The same message, directed to one receiver. Precondition: parse_rtps() accepts `message`.
std::vector<std::byte> directed(std::span<const std::byte> message, const link::DdsParticipant& to);

// --- admission

class DiscoveryFilter {
 public:
  static constexpr std::size_t kRoutersMax = link::Fleet::kRoutersMax;  // others are ignored
  static constexpr std::size_t kAnnouncedMax = 4096;  // size limit of announcements
  // Participants that address us; also the burst size.
  static constexpr std::uint64_t kAdmittedPerSecond = 10;

  // The actions for one message.
  struct Verdict {
    bool passes = false;                 // pass the message to the library
    std::vector<std::byte> first{};      // pass this message first, if not empty
    std::vector<std::byte> answer{};     // message to send back, if not empty
    std::vector<link::NetAddress> to{};  // its destinations
    // A router is new, or has changed its announcement.
    std::optional<link::Announcement> announced{};
    std::optional<link::DdsParticipant> gone{};
  };

  explicit DiscoveryFilter(const link::Announcement& self) : self_(self) {}

  Verdict on_message(Time now, std::span<const std::byte> bytes, bool multicast);
  // One of our own messages: answers are derived from it.
  void on_own(std::span<const std::byte> bytes);

  // Admits this router: returns the message to pass to the library; empty when it needs none. A
  // router that has not been announced yet, as after a change of addresses, is admitted when it is.
  std::vector<std::byte> admit(const link::DdsParticipant& participant);
  // The library has dropped this participant.
  void forget(const link::DdsParticipant& participant) { routers_.erase(participant); }
  // Removes and returns participants whose lease has expired.
  std::vector<link::DdsParticipant> expire(Time now);

 private:
  struct Router {
    Time last_received{};
    Duration lease{};
    bool admitted = false;
    link::Announcement announcement{};
    std::vector<std::byte> message{};  // its announcement
  };

  void on_announced(Time now, const link::DdsParticipant& from, std::span<const std::byte> message,
                    const link::Announcement& announcement, Duration lease, Verdict& verdict);
  // Changes a router from held to admitted: returns its announcement.
  std::vector<std::byte> take_held(const link::DdsParticipant& participant);

  const link::Announcement self_;
  std::optional<link::DdsParticipant> own_{};
  std::vector<std::byte> own_message_{};
  std::map<link::DdsParticipant, Router> routers_;
  std::set<link::DdsParticipant> wanted_;  // to be admitted when they are announced
  // Limits participants that address us.
  base::RateLimiter budget_{kAdmittedPerSecond, kAdmittedPerSecond};
};

}  // namespace tims::io
