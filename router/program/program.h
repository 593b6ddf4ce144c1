// The running router: creates its parts, in the order of their members, and runs them. Nothing else
// constructs.
#pragma once

#include "router/config/load.h"
#include "router/io/arguments.h"

namespace tims::program {

inline constexpr int kCannotStart = 1;

// Until SIGTERM or SIGINT. Returns the exit status; the reason is logged. `arguments` are read
// again at a reload.
int run(config::Loaded configuration, const io::Arguments& arguments);

}  // namespace tims::program
