// Fleet files: robots, their hosts, the lines between them, and timed faults. Pure.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/text.h"
#include "os/process.h"
#include "tools/cli/failure.h"
#include "tools/sim/quality.h"

namespace timsctl::sim {

// The programs of a host in addition to its router.
struct HostPrograms {
  std::vector<tims::os::Command> components;
  std::vector<std::string> robots;    // robot files that run here, relative to the fleet file
  std::vector<std::string> settings;  // of the router: "log.level=debug"
};

struct Robot {
  std::string name;  // "robot2"
  std::uint8_t system = 1;
  std::vector<std::string> hosts;  // the first runs the system router
  std::string link = "wifi";       // profile of its line to the base
  std::string cable = "cable";     // profile of the lines between its hosts
  std::map<std::string, HostPrograms, std::less<>>
      programs;  // by host: those of [host.X], then those of the robot
};

// A timed fault.
struct Step {
  tims::Duration at{};
  std::string line;                    // the affected line, or
  std::string host;                    // the affected host
  std::vector<std::string> arguments;  // for a line: see changed(); for a host: "kill" or "start"
  std::optional<tims::Duration> duration;  // it is undone after this time
  std::optional<tims::Duration> every;     // interval of repetition
};

struct Fleet {
  std::string name = "fleet";
  HostPrograms base;
  std::vector<Robot> robots;
  Profiles profiles;  // including the built-in ones
  std::vector<Step> steps;
};

struct FleetFile {
  Fleet fleet;  // valid only if there are no problems
  std::vector<base::Problem> problems;
};

// Reports every problem with file, line and column.
FleetFile read_fleet(const base::TextFile& file);

inline constexpr std::size_t kFleetNameMax = 15;
// Small letters and digits, and not too many: it becomes a part of names of namespaces.
bool is_fleet_name(std::string_view name);

}  // namespace timsctl::sim
