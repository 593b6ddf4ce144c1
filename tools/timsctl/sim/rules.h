// What makes a line bad, as text for tc and nft. Pure. What leaves an interface is shaped by tc,
// what comes in is thrown away by nft; what neither can do is the routers' part.
#pragma once

#include <string>

#include "tools/timsctl/json.h"
#include "tools/timsctl/sim/plan.h"

namespace timsctl::sim {

// For `tc`, at the sending end. Without netem only the rate.
CommandLine shaping(const LineEnd& sender, const Quality& quality, bool netem);

// For `nft -f -`, at the receiving end: takes the place of what was there.
std::string dropping(const LineEnd& receiver, const Quality& quality);

// What the router at the sending end is asked to do: delay, jitter, doubles and changes of the
// order, when the kernel has no netem. `link` is the router's name for the link.
json::object router_faults(const std::string& link, const Quality& quality);
bool needs_router(const Quality& quality);
// All of it, of a router that nobody helps; an empty `link`: all its links.
json::object all_faults(const std::string& link, const Quality& quality);

}  // namespace timsctl::sim
