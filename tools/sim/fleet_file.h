// What a fleet file says: robots, their hosts, the lines between them, and what happens when. Pure.
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

// What runs on a host beside its router.
struct HostPrograms {
  std::vector<tims::os::Command> components;
  std::vector<std::string> settings;  // of its router: "log.level=debug"
};

struct Robot {
  std::string name;  // "robot2"
  std::uint8_t system = 1;
  std::vector<std::string> hosts;  // the first is the system router's
  std::string link = "wifi";       // profile of its line to the base
  std::string cable = "cable";     // profile of the lines between its hosts
  std::map<std::string, HostPrograms, std::less<>> programs;  // by host: [host.X], its own behind
};

// Something that happens by itself.
struct Step {
  tims::Duration at{};
  std::string line;                        // or
  std::string host;                        // what it happens to
  std::vector<std::string> words;          // of a line: see changed(); of a host: "kill" or "start"
  std::optional<tims::Duration> duration;  // then it is undone
  std::optional<tims::Duration> every;     // again and again
};

struct Fleet {
  std::string name = "fleet";
  HostPrograms base;
  std::vector<Robot> robots;
  Profiles profiles;  // the built-in ones too
  std::vector<Step> steps;
};

struct FleetFile {
  Fleet fleet;  // to be used only when there are no problems
  std::vector<base::Problem> problems;
};

// Every problem with file, line and column.
FleetFile read_fleet(const base::TextFile& file);

inline constexpr std::size_t kFleetNameMax = 15;
// Small letters and digits, and not too many: it becomes a part of names of namespaces.
bool is_fleet_name(std::string_view name);

}  // namespace timsctl::sim
