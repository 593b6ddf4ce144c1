// Clients, routers and events as text, for the log and for reports. Pure.
#pragma once

#include <string>

#include "router/core/statistics.h"

namespace tims::io {

// "laser (pid 811)"
std::string client_text(const core::Peer& client);
// "robot1 (10.0.0.2:2010)"
std::string router_text(const core::Peer& router);
// One line of text: "Ladar(3/0) registered by laser (pid 811)".
std::string event_text(const core::Event& event, const AddressWidths& widths);

}  // namespace tims::io
