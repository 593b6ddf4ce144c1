// The router's counters in Prometheus' text format (version 0.0.4). Pure.
//
// Labels are from closed lists: however many mailboxes and clients there are, the page stays short.
#pragma once

#include <string>
#include <string_view>

#include "router/io/admin_source.h"

namespace tims::io {

inline constexpr std::string_view kMetricsType = "text/plain; version=0.0.4; charset=utf-8";

std::string metrics_text(const AdminSource& source, Time now);

}  // namespace tims::io
