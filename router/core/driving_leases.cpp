#include "router/core/driving_leases.h"

#include <algorithm>
#include <bit>
#include <span>

namespace tims::core {
namespace {

// Commands of the classes of RACK (rack/proxies). The router does not link them; a test compares.
constexpr std::int8_t kChassisMove = 21;
constexpr std::int8_t kChassisSetActivePilot = 23;
constexpr std::int8_t kPilotSetDestination = 21;
constexpr std::int8_t kPilotSetMultiDestination = 26;
constexpr std::int8_t kPathMake = 21;
constexpr std::int8_t kPathSetDestination = 23;
constexpr std::int8_t kPathSetRddf = 24;
constexpr std::int8_t kVehicleSetValue = 21;

bool all_zero(std::span<const std::byte> bytes) {
  return std::ranges::all_of(bytes, [](std::byte b) { return b == std::byte{0}; });
}

// The address that means "no pilot", in either byte order; its local id is ignored.
bool is_no_pilot(const Message& message) {
  const auto body = message.body();
  if (body.size() < 4) return false;
  const bool little = message.header.body_order() == std::endian::little;
  return std::ranges::all_of(body.subspan(little ? 1 : 0, 3),
                             [](std::byte b) { return b == std::byte{0xFF}; });
}

bool drives(const Message& message, std::uint32_t receiver, std::uint32_t sender) {
  const std::int8_t type = message.header.type;
  if (sender == class_id::kJoystick && type == type::kData) return !all_zero(message.body());
  switch (receiver) {
    case class_id::kChassis:
      if (type == kChassisMove) return !all_zero(message.body());
      return type == kChassisSetActivePilot && !is_no_pilot(message);
    case class_id::kPilot:
      return type == kPilotSetDestination || type == kPilotSetMultiDestination;
    case class_id::kPath:
      return type == kPathMake || type == kPathSetDestination || type == kPathSetRddf;
    case class_id::kVehicle:
      return type == kVehicleSetValue;
    default:
      return false;
  }
}

bool is_same_holder(const DrivingLease& lease, const DrivingLease& other) {
  return lease.client.id == other.client.id && lease.mailbox == other.mailbox;
}

}  // namespace

bool is_driven_class(std::uint32_t number) {
  return number == class_id::kChassis || number == class_id::kPilot || number == class_id::kPath ||
         number == class_id::kVehicle;
}

std::optional<std::uint32_t> driven_robot(const Message& message, const AddressWidths& widths) {
  const Address::Fields to = message.header.dest.fields(widths);
  const Address::Fields from = message.header.src.fields(widths);
  if (!drives(message, to.class_id, from.class_id)) return std::nullopt;
  return to.system;
}

DrivingLeases::Change DrivingLeases::change(Time now, LeaseVerb verb, const DrivingLease& wanted) {
  Change change = make_change(now, verb, wanted);
  set_next_end();
  return change;
}

DrivingLeases::Change DrivingLeases::make_change(Time now, LeaseVerb verb,
                                                 const DrivingLease& wanted) {
  const auto at = std::ranges::lower_bound(leases_, wanted.robot, {}, &DrivingLease::robot);
  const bool held = at != leases_.end() && at->robot == wanted.robot;
  const bool own = held && is_same_holder(*at, wanted);
  if (verb == LeaseVerb::kRelease || verb == LeaseVerb::kRenew) {
    if (!own) return {.result = LeaseResult::kNotHeld};
    at->until = now + kTime;
    if (verb == LeaseVerb::kRenew) return {};
    const Ended ended{*at, LeaseEnd::kReleased};
    leases_.erase(at);
    return {.ended = ended};
  }
  DrivingLease lease = wanted;
  lease.since = own ? at->since : now;
  lease.until = now + kTime;
  if (own) {
    *at = lease;
    return {};
  }
  if (held && verb == LeaseVerb::kTake) return {.result = LeaseResult::kTaken};
  if (held) {
    const Ended ended{*at, LeaseEnd::kTakenOver};
    *at = lease;
    return {.ended = ended, .began = true};
  }
  if (leases_.size() >= kLeasesMax) return {.result = LeaseResult::kTooMany};
  leases_.insert(at, lease);
  return {.began = true};
}

std::vector<DrivingLeases::Ended> DrivingLeases::end_of(ClientId client) {
  return end_if(LeaseEnd::kDisconnected,
                [&](const DrivingLease& lease) { return lease.client.id == client; });
}

std::vector<DrivingLeases::Ended> DrivingLeases::end_old(Time now) {
  return end_if(LeaseEnd::kNotRenewed,
                [&](const DrivingLease& lease) { return now >= lease.until; });
}

template <typename Condition>
std::vector<DrivingLeases::Ended> DrivingLeases::end_if(LeaseEnd why, Condition condition) {
  std::vector<Ended> ended;
  std::erase_if(leases_, [&](const DrivingLease& lease) {
    const bool ends = condition(lease);
    if (ends) ended.push_back({lease, why});
    return ends;
  });
  set_next_end();
  return ended;
}

// Asked for in every turn of the router, changed rarely.
void DrivingLeases::set_next_end() {
  next_end_ = kNever;
  for (const DrivingLease& lease : leases_) next_end_ = std::min(next_end_, lease.until);
}

const DrivingLease* DrivingLeases::find(std::uint32_t robot) const {
  const auto at = std::ranges::lower_bound(leases_, robot, {}, &DrivingLease::robot);
  return at != leases_.end() && at->robot == robot ? &*at : nullptr;
}

const DrivingLease* DrivingLeases::against(const Message& message, ClientId sender,
                                           bool owns_source, bool over_link,
                                           const AddressWidths& widths) const {
  if (leases_.empty()) return nullptr;
  const auto robot = driven_robot(message, widths);
  const DrivingLease* lease = robot ? find(*robot) : nullptr;
  if (lease == nullptr) return nullptr;
  const Address source = message.header.src;
  const bool is_holder =
      over_link ? lease->mailbox.raw() == 0 || source == lease->mailbox || source == lease->stick
                : owns_source;
  if (lease->client.id == sender && is_holder) return nullptr;
  const Address::Fields from = source.fields(widths);
  const bool is_part = from.system == *robot && from.class_id >= class_id::kTest &&
                       from.class_id != class_id::kJoystick;
  return is_part && (owns_source || over_link) ? nullptr : lease;
}

}  // namespace tims::core
