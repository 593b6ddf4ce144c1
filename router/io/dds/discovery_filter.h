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
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "router/link/datagram.h"
#include "router/link/estimators.h"
#include "tims/time.h"

namespace tims::io {

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

  explicit DiscoveryFilter(const link::Announcement& self) : self_(self) {
    budget_.set(kAdmittedPerSecond, kAdmittedPerSecond);
  }

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
  link::TokenBucket budget_;  // of those that address us
};

}  // namespace tims::io
