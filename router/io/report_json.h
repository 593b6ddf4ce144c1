// The core's reports as JSON, with the names of ADMIN.md. Pure.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include <boost/json/object.hpp>

#include "router/core/report.h"
#include "router/io/admin_source.h"

namespace tims::io {

using WallTime = std::chrono::sys_time<Duration>;

// Two clocks read at the same moment: events carry the monotonic one, people want the other.
struct Clocks {
  Time now{};
  WallTime wall{};

  [[nodiscard]] WallTime wall_time(Time at) const { return wall - (now - at); }
};

std::string rfc3339(WallTime time);  // "2026-11-21T02:15:00.123456Z"
// JSON is UTF-8, names of clients are whatever they sent: broken bytes become '?'.
std::string as_utf8(std::string_view text);

// 16 hex digits: JSON's numbers do not hold 64 bits everywhere.
std::string epoch_text(std::uint64_t epoch);

// `widths`: those of the router's addresses, which names are made with.
boost::json::object to_json(Address address, const AddressWidths& widths);
boost::json::object to_json(const core::Party& party);
boost::json::object to_json(const core::ClientReport& report);
boost::json::object to_json(const core::MailboxReport& report, const AddressWidths& widths);
boost::json::object to_json(const core::RouteReport& report, Address to,
                            const AddressWidths& widths);
boost::json::object to_json(const core::CountReport& report);
boost::json::object to_json(const core::Event& event, const Clocks& clocks,
                            const AddressWidths& widths);
boost::json::object to_json(const core::StatusReport& report, const ProcessReport& process);
boost::json::object to_json(const MailboxCounts& counts);
void add_fill(boost::json::object& mailbox, const MailboxFill& fill);

// One line for people: "Ladar(3/0) registered by laser (pid 811)".
std::string event_text(const core::Event& event, const AddressWidths& widths);

}  // namespace tims::io
