// Checks of a robot file beyond its form: names, ranges and choices of parameters by the
// descriptions of the programs, and the files that they name. Pure.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/toml.h"
#include "tools/configuration/description.h"
#include "tools/robot/robot_file.h"

namespace timsctl::configuration {

struct Finding {
  std::string file{};
  std::uint32_t line = 0;  // 0: no place
  std::uint32_t column = 0;
  std::string path{};  // of the value
  std::string text{};
  bool is_error = true;
  std::string host{};
};

Finding finding_of(const base::Problem& problem);
bool has_errors(const std::vector<Finding>& findings);

struct Surroundings {
  Describe describe;
  // Whether a file exists, named as a parameter names it (relative to the folder of robot files).
  std::function<bool(const std::string& name)> has_file;
  // Names of the files beside it, for a suggestion.
  std::function<std::vector<std::string>(const std::string& name)> files_beside;
  int priority_max = 99;  // of real-time tasks
};

// A component of a robot file that is a program with a description, or may have one.
struct Instance {
  std::string file{};
  std::string name{};  // in the robot
  std::string program{};
  std::string host{};      // of the robot file; empty: the host of the file
  std::size_t number = 0;  // in the file
  base::Place at{};
  std::int64_t system = 0;
  std::int64_t instance = 0;
  std::map<std::string, std::string> values{};  // parameters that the file sets
  const Description* described = nullptr;

  // What the file sets, else the default.
  [[nodiscard]] std::string value(std::string_view parameter) const;
  // "Ladar(1/0)"; empty without a description.
  [[nodiscard]] std::string address() const;
};

std::vector<Instance> instances_of(const base::TextFile& file, const robot::RobotFile& robot,
                                   const Describe& describe);

std::vector<Finding> check_robot(const base::TextFile& file, const Surroundings& around);

// What differs between two texts of a robot file, for people, and which components restart:
// "Scan2d maxRange 8000 -> 10000 mm; needs restart of Scan2d".
struct RobotDifference {
  std::vector<std::string> sentences;
  // (component, "restart", "start" or "stop")
  std::vector<std::pair<std::string, std::string>> effects;
};
RobotDifference robot_difference(const std::string& before, const std::string& after,
                                 const std::string& file, const Describe& describe);

}  // namespace timsctl::configuration
