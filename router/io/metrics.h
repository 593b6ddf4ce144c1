// The router's counters in Prometheus' text format (version 0.0.4). Label values come from closed
// lists, so the page stays short however many mailboxes and clients there are. Pure.
#pragma once

#include <string>

#include "router/io/admin_source.h"

namespace tims::io {

std::string metrics_text(const AdminSource& source, Time now);

}  // namespace tims::io
