#include "tools/timsctl/sim/names.h"

#include <fmt/format.h>

namespace timsctl::sim {

std::string host_name(const Robot& robot, std::string_view host) {
  return fmt::format("{}-{}", robot.name, host);
}

std::string line_name(const Robot& robot, std::string_view host) {
  return fmt::format("{}-{}", robot.name, host == robot.hosts.front() ? kBase : host);
}

std::vector<std::string> host_names_of(const Fleet& fleet) {
  std::vector<std::string> names = {std::string(kBase)};
  for (const Robot& robot : fleet.robots)
    for (const std::string& host : robot.hosts) names.push_back(host_name(robot, host));
  return names;
}

std::vector<std::string> line_names(const Fleet& fleet) {
  std::vector<std::string> names;
  for (const Robot& robot : fleet.robots)
    for (const std::string& host : robot.hosts) names.push_back(line_name(robot, host));
  return names;
}

}  // namespace timsctl::sim
