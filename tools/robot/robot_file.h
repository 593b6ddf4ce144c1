// Robot files: the programs of a robot, and the hosts on which they run. Pure.
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

// When a program that has ended is restarted.
enum class Restart : std::uint8_t { kNever, kOnFailure, kAlways };

struct Component {
  std::string name;           // unique in the robot: "PilotWallFollowing-1"
  tims::os::Command command;  // placeholders are replaced
  std::string host;           // empty: where timsctl runs
  Restart restart = Restart::kOnFailure;
  bool notifies = true;  // sends READY=1, like our components; other commands do not

  bool operator==(const Component&) const = default;
};

// Another computer of the robot.
struct Host {
  std::string name;
  std::string ssh;     // destination for ssh: "pi@arm"
  std::string router;  // router on that host, as for --host of timsctl; empty: the default
  // What `timsctl deploy` brings there.
  std::vector<std::string> packages{};  // names of Debian packages; empty: those of [deploy]
  std::string files{};                  // folder beside the robot file; becomes /etc/tims
};

// [deploy]: the computer of the components without host, and from where packages come.
struct Deploy {
  Host host{};             // its name is kMainHost; without ssh it is not deployed
  std::string repository;  // a folder, or an entry of sources.list; empty: what hosts' apt knows
};
inline constexpr std::string_view kMainHost = "main";

struct Robot {
  std::string name;
  std::int64_t system = 0;
  std::string files;  // folder of files that messages name; empty: the default of the components
  std::vector<Host> hosts;
  std::vector<Component> components;
  Deploy deploy{};
};

struct RobotFile {
  Robot robot;  // valid only if there are no problems
  std::vector<base::Problem> problems;
  std::vector<base::Problem> hints{};  // keys by their former names
};

inline constexpr std::size_t kNameMax = 31;  // it is used as the name of a folder
inline constexpr std::size_t kComponentsMax = 200;
// Of systems and instances; components refuse what does not fit into the fleet's addresses.
inline constexpr std::int64_t kIdMax = 65535;

bool is_name(std::string_view text);  // letters, digits, - and _

// Reports every problem with its position. `name`: used if the file has no name. `system`:
// overrides the value in the file.
RobotFile read_robot(const base::TextFile& file, const std::string& name,
                     std::optional<std::int64_t> system = {});

// Changes parameters of one component in the text of a robot file. All other text, including
// comments and order, is unchanged. Pure.

struct ParameterChange {
  std::string name;
  std::optional<std::string> before;  // empty: not in the file before
  std::string after;

  bool operator==(const ParameterChange&) const = default;
};

struct EditedFile {
  std::string text;
  std::vector<ParameterChange> changes;  // without those that are already in the file
};

// `component`: index in Robot::components, as read with `system`. The new text is parsed as by
// `timsctl up` and must differ in exactly this change; otherwise the error is kInvalidArgument.
tims::Result<EditedFile> with_parameters(const base::TextFile& file,
                                         std::optional<std::int64_t> system, std::size_t component,
                                         const std::map<std::string, std::string>& parameters);

// Saving parameters that were set at run time to the robot file.

// The origin of a robot: its file and the text that was read.
struct RobotText {
  std::string file;  // its path; empty: stdin
  std::string text;
  std::optional<std::int64_t> system{};  // overrides the value in the file
};

// `component`: index in the file. The file is replaced atomically, also in case of a power failure.
// Returns the path and the changes, and updates `source`. Throws Failure: the robot was not read
// from a file, the file has changed, or it cannot be written.
json::object save_parameters(RobotText& source, std::size_t component,
                             const std::map<std::string, std::string>& parameters, bool dry_run);

// What is the same for two processes of one component: "ChassisSim, system 3, instance 0". Two
// robot files that start the same components at one router would fight for their addresses and
// devices. Of `nice -n 1 World --system=3` it is the program before the first option with two
// dashes. Empty: the command line is not that of a component.
std::optional<std::string> component_of(const tims::os::Command& command);

}  // namespace timsctl::robot
