// What a robot file says: the programs of a robot, and where they run. Pure.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "router/config/load.h"
#include "tools/timsctl/split_command.h"

namespace timsctl::robot {

// When a program that has ended is started again.
enum class Restart : std::uint8_t { kNever, kOnFailure, kAlways };

struct Component {
  std::string name;     // among the robot's components: "PilotWallFollowing-1"
  CommandLine command;  // placeholders are filled in
  std::string host;     // empty: where timsctl runs
  Restart restart = Restart::kOnFailure;
  bool tells = true;  // when it is ready, as our components do; other commands do not

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
  std::vector<tims::config::Problem> problems;
};

inline constexpr std::size_t kNameMax = 31;  // it becomes the name of a folder
inline constexpr std::size_t kComponentsMax = 200;
inline constexpr std::int64_t kIdMax = 255;

bool is_name(std::string_view text);  // letters, digits, - and _

// Every problem with its place. `name`: of a robot that does not say its own. `system`: in place of
// the file's.
RobotFile read_robot(const tims::config::File& file, const std::string& name,
                     std::optional<std::int64_t> system = {});

}  // namespace timsctl::robot
