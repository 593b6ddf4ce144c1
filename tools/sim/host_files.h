// The configuration of a simulated host, in a folder that looks as /etc/tims of an installed one:
// its router's file and copies of its robots' files. So the agent of the host may change them, and
// the files they come from stay as they are.
#pragma once

#include <cstdint>
#include <string>

#include "base/text.h"
#include "tools/sim/plan.h"

namespace timsctl::sim {

// The text of a robot file with this system in place of its own, else unchanged. Pure. Throws
// Failure if it is no TOML.
std::string with_system(const base::TextFile& robot, std::uint8_t system);

// What robot files name by relative paths (maps, worlds, routes) is linked beside the copies.
// `sources`: the folder of the fleet file. Throws Failure: a file cannot be read or written.
void write_host_files(const PlannedHost& host, const std::string& sources);

}  // namespace timsctl::sim
