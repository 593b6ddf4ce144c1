// A simulated world, asked: where it is, and what its robots have.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tims/address.h"

namespace timsctl {

class Context;

// Of --world, or the only one that the router knows. Throws Failure.
tims::Address find_world(Context& context);
// Robots and what is plugged into each: {"scout", "laser"}. Throws Failure.
std::vector<std::pair<std::string, std::string>> world_devices(Context& context);

}  // namespace timsctl
