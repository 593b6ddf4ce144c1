// Requests to a simulated world: its address, its robots and their devices.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tims/address.h"

namespace timsctl {

class Context;

// The address of --world, or of the only World that the router knows. Throws Failure.
tims::Address find_world(Context& context);
// Pairs of robot and device: {"scout", "laser"}. Throws Failure.
std::vector<std::pair<std::string, std::string>> world_devices(Context& context);

}  // namespace timsctl
