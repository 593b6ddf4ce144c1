// A robot file with other parameters for one of its components; all else stays as it is written,
// comments and order included. Pure.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tims/result.h"
#include "tools/timsctl/robot/robot.h"

namespace timsctl::robot {

struct ParameterChange {
  std::string name;
  std::optional<std::string> before;  // nothing: the file did not have it
  std::string after;

  bool operator==(const ParameterChange&) const = default;
};

struct EditedFile {
  std::string text;
  std::vector<ParameterChange> changes;  // without those that the file has already
};

// `component`: which of Robot::components, as read with `system`. kInvalidArgument says what cannot
// be written there: the new text is read as `timsctl up` would, and must mean just this change.
tims::Result<EditedFile> with_parameters(const tims::config::File& file,
                                         std::optional<std::int64_t> system, std::size_t component,
                                         const std::map<std::string, std::string>& parameters);

}  // namespace timsctl::robot
