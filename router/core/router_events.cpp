#include "router/core/router_events.h"

#include <string>

namespace tims::core {
namespace {

// "tablet 2 on robot 3"
std::string lease_text(const DrivingLease& lease) {
  return std::string(lease.holder.view()) + " on robot " + std::to_string(lease.robot);
}

}  // namespace

EventKind kind_of(Registration::Status status) {
  switch (status) {
    case Registration::Status::kOk:
      return EventKind::kRegistered;
    case Registration::Status::kTooMany:
      return EventKind::kMailboxLimit;
    default:
      return EventKind::kAddressRefused;
  }
}

EventKind kind_of_end(PortKind port, CloseReason reason) {
  if (port == PortKind::kLink) return EventKind::kLinkDown;
  switch (reason) {
    case CloseReason::kWatchdog:
      return EventKind::kWatchdogClosed;
    case CloseReason::kTooShort:
    case CloseReason::kTooLong:
    case CloseReason::kBadRecord:
      return EventKind::kProtocolError;
    case CloseReason::kOutOfMemory:
    case CloseReason::kStalled:
      return EventKind::kMemoryClosed;
    default:
      return EventKind::kClientWent;
  }
}

Event lease_taken(Time now, const DrivingLease& lease) {
  return {.at = now,
          .kind = EventKind::kLeaseTaken,
          .address = lease.mailbox,
          .client = lease.client,
          .text = std::string_view(lease_text(lease))};
}

Event lease_ended(Time now, const DrivingLeases::Ended& ended) {
  const auto& [lease, why] = ended;
  return {.at = now,
          .kind = EventKind::kLeaseEnded,
          .address = lease.mailbox,
          .client = lease.client,
          .text = std::string_view(lease_text(lease) + ": " +
                                   std::string(label(kLeaseEnds, why).sentence))};
}

Event driving_refused(Time now, const Header& header, const Peer& sender,
                      const DrivingLease& lease) {
  return {.at = now,
          .kind = EventKind::kDrivingRefused,
          .address = header.src,
          .client = sender,
          .text = std::string_view(lease_text(lease)),
          .owner = lease.client};
}

Event judged(Time now, EventKind kind, const Header& header, const Peer& sender,
             std::string_view rule) {
  return {
      .at = now,
      .kind = kind,
      .address = header.dest,
      .client = sender,
      .text = std::string_view("type " + std::to_string(header.type) + " by " + std::string(rule))};
}

Event denied(Time now, const policy::DenialReport& report) {
  return {.at = now,
          .kind = EventKind::kDenied,
          .text = std::string_view(std::to_string(report.messages) + " more messages by rule \"" +
                                   report.rule + "\" for " + report.subject)};
}

}  // namespace tims::core
