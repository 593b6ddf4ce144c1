// Whether two robot files start the same components: a second one at the same router would only
// fight with the first for its addresses and devices. Pure.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "os/process.h"

namespace timsctl::robot {

// What is the same for two processes of one component: "ChassisSim, system 3, instance 0". Of
// `nice -n 1 World --system=3` it is the program before the first option with two dashes. Empty:
// the command line is not that of a component.
std::optional<std::string> component_of(const tims::os::Command& command);

}  // namespace timsctl::robot
