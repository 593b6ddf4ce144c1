// Who drives which robot: at most one holder of a robot's driving lease.
//
// While somebody holds it, driving commands of others for this robot are refused: speeds,
// destinations, paths, the choice of the pilot, positions of joysticks. Who never asks for a lease
// is not hindered while nobody else holds it. The robot's own components always drive: a pilot
// moves its chassis. Commands that stop are never refused: speed 0, no pilot, hold, off.
//
// A lease ends when its holder releases it, is disconnected, or does not renew it for kTime;
// nobody else gets it before, unless he takes it over explicitly. Pure.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "router/core/statistics.h"
#include "router/core/types.h"
#include "tims/address.h"
#include "tims/text.h"
#include "tims/time.h"

namespace tims::core {

struct DrivingLease {
  std::uint32_t robot = 0;  // system
  Text<32> holder{};        // as it names itself: "tablet 2"
  Peer client{};            // from which it was taken; of a holder elsewhere, the link
  Address mailbox{};        // of the holder; 0: any of the client
  Address stick{};          // a joystick of the holder; 0: none
  Time since{};
  Time until{};
};

enum class LeaseVerb : std::uint8_t { kTake, kTakeOver, kRenew, kRelease };

// kNotHeld: to be renewed or released, but it has ended or belongs to another.
enum class LeaseResult : std::uint8_t { kDone, kTaken, kNotHeld, kTooMany };

enum class LeaseEnd : std::uint8_t { kReleased, kTakenOver, kDisconnected, kNotRenewed };
constexpr std::array<Label<LeaseEnd>, 4> kLeaseEnds{{
    Label<LeaseEnd>{LeaseEnd::kReleased, "released", "it was released"},
    Label<LeaseEnd>{LeaseEnd::kTakenOver, "taken_over", "somebody took it over"},
    Label<LeaseEnd>{LeaseEnd::kDisconnected, "disconnected", "the holder's connection ended"},
    Label<LeaseEnd>{LeaseEnd::kNotRenewed, "not_renewed", "it was not renewed"},
}};
static_assert(complete(kLeaseEnds, LeaseEnd::kNotRenewed));

// Whether mailboxes of this class take commands that drive a robot.
bool is_driven_class(std::uint32_t number);

// The robot that a message drives; empty: it does not drive, or it stops.
std::optional<std::uint32_t> driven_robot(const Message& message, const AddressWidths& widths);

class DrivingLeases {
 public:
  // Holders renew it several times within this time.
  static constexpr Duration kTime = std::chrono::seconds(5);
  static constexpr std::size_t kLeasesMax = 4096;

  struct Ended {
    DrivingLease lease{};
    LeaseEnd why = LeaseEnd::kReleased;
  };
  struct Change {
    LeaseResult result = LeaseResult::kDone;
    std::optional<Ended> ended{};
    bool began = false;
  };
  // `wanted`: the robot and the holder; its times are ignored. Taking one's own lease renews it.
  Change change(Time now, LeaseVerb verb, const DrivingLease& wanted);
  std::vector<Ended> end_of(ClientId client);
  std::vector<Ended> end_old(Time now);
  // When end_old() has something to do; kNever: nobody holds a lease.
  [[nodiscard]] Time next_end() const { return next_end_; }

  [[nodiscard]] bool empty() const { return leases_.empty(); }
  // Null: nobody holds it. Valid until the next change.
  [[nodiscard]] const DrivingLease* find(std::uint32_t robot) const;
  // In order of robots.
  [[nodiscard]] const std::vector<DrivingLease>& all() const { return leases_; }

  // The lease that forbids this message; null: it may pass. `owns_source`: the message's source is
  // a mailbox of the sender. `over_link`: the sender is another router.
  [[nodiscard]] const DrivingLease* against(const Message& message, ClientId sender,
                                            bool owns_source, bool over_link,
                                            const AddressWidths& widths) const;

 private:
  Change make_change(Time now, LeaseVerb verb, const DrivingLease& wanted);
  template <typename Condition>
  std::vector<Ended> end_if(LeaseEnd why, Condition condition);
  void set_next_end();

  std::vector<DrivingLease> leases_;  // by robot
  Time next_end_ = kNever;
};

}  // namespace tims::core
