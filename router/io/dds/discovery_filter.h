// Which participants our own library hears of. Fast DDS makes endpoints towards everybody it
// discovers, and announces itself again to each: n routers that start at once are n * n encounters,
// of some twenty messages each. A router needs those few it has links with. So what others announce
// is read here and kept, and the library gets it once either side wants the other:
//
//     held ── admit(): we send to it; or it addresses us ──► admitted ── forget() ──► held again
//
// Until then all other messages of a participant are dropped; so are those of participants that
// are no routers of our fleet. Of those that address us a few a second are admitted; the others
// do it again within a second.
//
// Of RTPS 2.2 (8.3, 9.4) as much is read as tells who a message is from and for, what a participant
// announces (SPDP, 8.5.3), and what a heartbeat asks for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "base/rate_limiter.h"
#include "router/link/datagram.h"
#include "router/link/transport.h"
#include "tims/time.h"

namespace tims::io {

// --- messages

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

// --- who is heard

class DiscoveryFilter {
 public:
  static constexpr std::size_t kRoutersMax = 4096;         // more are not heard
  static constexpr std::size_t kAnnouncedMax = 4096;       // bytes of a message that announces
  static constexpr std::uint64_t kAdmittedPerSecond = 10;  // that address us; as many at once

  // What follows from one message.
  struct Verdict {
    bool passes = false;                            // the library is to get it
    std::vector<std::byte> first{};                 // and before it this one, if not empty
    std::vector<std::byte> answer{};                // what goes back, if not empty
    std::vector<link::NetAddress> to{};             // where to
    std::optional<link::Announcement> announced{};  // a router is new, or says something else
    std::optional<link::DdsParticipant> gone{};
  };

  explicit DiscoveryFilter(const link::Announcement& self) : self_(self) {}

  Verdict on_message(Time now, std::span<const std::byte> message, bool multicast);
  // One of ours: the answer is taken from it.
  void on_own(std::span<const std::byte> message);

  // This router is to be discovered: what the library is to get. Empty: nothing is missing, or the
  // router is not known.
  std::vector<std::byte> admit(const link::DdsParticipant& who);
  // The library has dropped it.
  void forget(const link::DdsParticipant& who) { routers_.erase(who); }
  // Who has been silent for too long.
  std::vector<link::DdsParticipant> expire(Time now);

 private:
  struct Router {
    Time heard{};
    Duration lease{};
    bool admitted = false;
    link::Announcement announcement{};
    std::vector<std::byte> message{};  // in which it announced itself
  };

  void on_announced(Time now, const link::DdsParticipant& from, std::span<const std::byte> message,
                    const link::Announcement& announcement, Duration lease, Verdict& verdict);

  const link::Announcement self_;
  std::optional<link::DdsParticipant> own_{};
  std::vector<std::byte> own_message_{};
  std::map<link::DdsParticipant, Router> routers_;
  base::RateLimiter budget_{kAdmittedPerSecond, kAdmittedPerSecond};  // of those that address us
};

}  // namespace tims::io
