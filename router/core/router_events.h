// The events that decisions of the router become.
#pragma once

#include <string_view>

#include "router/core/driving_leases.h"
#include "router/core/router.h"
#include "router/core/statistics.h"
#include "router/policy/enforcer.h"
#include "tims/message.h"
#include "tims/time.h"

namespace tims::core {

EventKind kind_of(Registration::Status status);
EventKind kind_of_end(PortKind port, CloseReason reason);

Event lease_taken(Time now, const DrivingLease& lease);
Event lease_ended(Time now, const DrivingLeases::Ended& ended);
Event driving_refused(Time now, const Header& header, const Peer& sender,
                      const DrivingLease& lease);

// `rule`: which one, and for whom.
Event judged(Time now, EventKind kind, const Header& header, const Peer& sender,
             std::string_view rule);
Event denied(Time now, const policy::DenialReport& report);

}  // namespace tims::core
