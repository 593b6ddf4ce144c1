// Which of the router's events become lines of the log.
#pragma once

#include "router/core/statistics.h"
#include "router/io/limited_log.h"
#include "router/io/log.h"
#include "tims/address.h"

namespace tims::io {

void log_event(Log& log, LimitedLog& limited_log, const core::Event& event,
               const AddressWidths& widths);

}  // namespace tims::io
