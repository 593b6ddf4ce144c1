// Parameters that were set while a robot runs, into its file.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "tools/timsctl/json.h"

namespace timsctl::robot {

// Where a robot was read from, and what stood there.
struct RobotText {
  std::string file;  // its path; empty: stdin
  std::string text;
  std::optional<std::int64_t> system{};  // in place of the file's
};

// `component`: which one of the file. After a power cut the file is the old or the new one. Returns
// its path and what changes; `source` is what stands there now. Throws Failure: not from a file, no
// longer what was read, not to be written.
json::object save_parameters(RobotText& source, std::size_t component,
                             const std::map<std::string, std::string>& parameters, bool dry_run);

}  // namespace timsctl::robot
