// What must hold between the values of a configuration, after each of them has been read.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "router/config/load.h"

namespace tims::config {

// Keys that were written with a value that was refused, and items ("link[0]") with an unknown key:
// what follows from those mistakes is not told as well.
using Refused = std::map<std::string, Origin, std::less<>>;

struct Written {
  const Origins& origins;
  const Refused& refused;
};

std::vector<Problem> check(const Config& config, const Written& written);

}  // namespace tims::config
