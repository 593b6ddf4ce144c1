// The reports that the admin protocol (ADMIN.md) sends, as JSON: SI units, names of enumerators,
// null for unknown values. Texts may contain arbitrary bytes and are converted to UTF-8. Pure.
#pragma once

#include <cstdint>
#include <string>

#include <boost/json/fwd.hpp>

#include "router/core/report.h"
#include "router/io/admin_source.h"

namespace tims::io {

// 16 hex digits, because JSON numbers do not hold 64 bits in every implementation.
std::string epoch_text(std::uint64_t epoch);

boost::json::object to_json(Address address, const AddressWidths& widths);
boost::json::object to_json(const core::Peer& peer);
boost::json::object to_json(const core::StatusReport& router, const ProcessReport& process);
boost::json::object to_json(const core::ClientReport& report);
boost::json::object to_json(const core::MailboxReport& report, const AddressWidths& widths);
boost::json::object to_json(const MailboxFill& fill);
boost::json::object to_json(const shm::Counters& counts);
// The result of routing a message; the set of fields depends on the verdict.
boost::json::object to_json(const core::RouteReport& report, Address to,
                            const AddressWidths& widths);
boost::json::object to_json(const core::CountReport& report);
boost::json::object to_json(const core::Event& event, const Clocks& clocks,
                            const AddressWidths& widths);

boost::json::object to_json(const core::RuleReport& report);
boost::json::object to_json(const core::VerdictReport& report);

// A newest value without its body.
boost::json::object to_json(const core::NewestValues::Value& value, const AddressWidths& widths,
                            Time now);
boost::json::object to_json(const core::NewestValues::Counts& counts);
boost::json::object to_json(const core::StreamReport& report, const AddressWidths& widths);
boost::json::object to_json(const core::DrivingLease& lease, const AddressWidths& widths, Time now);

// The router that answers, as an entry of the router list.
boost::json::object to_json(const link::Identity& self, const ProcessReport& process);
// The router at the other end of a link.
boost::json::object to_json(const link::Link& link, Time now);
// A router that a link announced before the link went down.
boost::json::object to_json(const core::MissingRouter& missing, const AddressWidths& widths,
                            Time now);
// One link with all its state. `faults`: those in force; null: none.
boost::json::object to_json(const link::Links& links, const link::Link& link,
                            const core::Router& router, const link::Faults* faults, Time now);
boost::json::object to_json(const DdsReport& report);
// A router that announces itself in the fleet.
boost::json::object to_json(const link::Links& links, const link::Announcement& announcement);

}  // namespace tims::io
