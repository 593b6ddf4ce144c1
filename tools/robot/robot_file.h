// What a robot file says: the programs of a robot, and where they run. Pure.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/text.h"
#include "os/process.h"
#include "tims/result.h"
#include "tools/cli/failure.h"
#include "tools/cli/output.h"

namespace timsctl::robot {

// When a program that has ended is started again.
enum class Restart : std::uint8_t { kNever, kOnFailure, kAlways };

struct Component {
  std::string name;           // among the robot's components: "PilotWallFollowing-1"
  tims::os::Command command;  // placeholders are filled in
  std::string host;           // empty: where timsctl runs
  Restart restart = Restart::kOnFailure;
  bool notifies = true;  // when it is ready, as our components do; other commands do not

  bool operator==(const Component&) const = default;
};

// Another computer of the robot.
struct Host {
  std::string name;
  std::string ssh;     // how ssh calls it: "pi@arm"
  std::string router;  // there, as --host of timsctl; empty: the default one
};

struct Robot {
  std::string name;
  std::int64_t system = 0;
  std::vector<Host> hosts;
  std::vector<Component> components;
};

struct RobotFile {
  Robot robot;  // to be used only when there are no problems
  std::vector<base::Problem> problems;
};

inline constexpr std::size_t kNameMax = 31;  // it becomes the name of a folder
inline constexpr std::size_t kComponentsMax = 200;
inline constexpr std::int64_t kIdMax = 255;

bool is_name(std::string_view text);  // letters, digits, - and _

// Every problem with its place. `name`: of a robot that does not say its own. `system`: in place of
// the file's.
RobotFile read_robot(const base::TextFile& file, const std::string& name,
                     std::optional<std::int64_t> system = {});

// A robot file with other parameters for one of its components; all else stays as it is written,
// comments and order included. Pure.

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
tims::Result<EditedFile> with_parameters(const base::TextFile& file,
                                         std::optional<std::int64_t> system, std::size_t component,
                                         const std::map<std::string, std::string>& parameters);

// Parameters that were set while a robot runs, into its file.

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
