// What is left of a fleet on the disk of this host: /run/tims-sim/NAME. A fleet runs as long as
// somebody listens at its control socket; everything else under its name is a leftover.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/cli/failure.h"
#include "tools/cli/json.h"
#include "tools/cli/signals.h"

namespace timsctl::sim {

std::string folder_of(std::string_view fleet);
std::string control_socket(std::string_view fleet);

// All that have a folder or a namespace, running or not.
std::vector<std::string> fleets();
bool is_running(std::string_view fleet);

// The state as the fleet's process wrote it last; empty when it has not.
json::object read_state(std::string_view fleet);
void write_state(std::string_view fleet, const json::object& state);

// Removes everything of a fleet that does not run: processes, namespaces, files. False: there was
// nothing.
bool clean_up(std::string_view fleet);

// Asks the fleet's process. Throws Failure: it does not run, it does not answer, it said no.
json::object ask_fleet(std::string_view fleet, const json::object& question, const Signals& signals,
                       tims::Duration timeout);

// The one that is meant: the name, or the only one that runs. Throws Failure.
std::string chosen_fleet(std::string_view name);

Failure no_such(std::string_view what, std::string_view name,
                std::span<const std::string_view> known);

// Throws Failure unless this process may make namespaces.
void need_root();

}  // namespace timsctl::sim
