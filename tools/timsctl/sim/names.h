// How robots, hosts and lines are called. Pure.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tools/timsctl/sim/fleet.h"

namespace timsctl::sim {

inline constexpr std::int64_t kSystemMax = 250;   // a robot's address at the base is 10.0.0.SYSTEM
inline constexpr std::size_t kHostsMax = 200;     // of a robot
inline constexpr std::size_t kRobotNameMax = 10;  // an interface of the base is called after it
inline constexpr std::size_t kHostNameMax = 12;

inline constexpr std::string_view kBase = "base";

std::string host_name(const Robot& robot, std::string_view host);  // "robot1-main"
// "robot1-base" for the first host, "robot1-arm" for the others: the line to the host above.
std::string line_name(const Robot& robot, std::string_view host);
std::vector<std::string> host_names_of(const Fleet& fleet);
std::vector<std::string> line_names(const Fleet& fleet);

}  // namespace timsctl::sim
