// Robots that run on this host: a folder for each, with the socket at which its timsctl listens.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tools/cli/json.h"
#include "tools/cli/signals.h"

namespace timsctl::robot {

// Two robots of one name may run, at different routers: the name and what tells the router from
// others ("sim-1@5c0ffee5") are the key of everything below.
std::string key_of(std::string_view name, std::string_view router);
std::string_view name_of(std::string_view key);

std::string folder_of(std::string_view robot);
std::string control_socket(std::string_view robot);
std::string status_socket(std::string_view robot);  // where its components say how they are
std::string log_file(std::string_view robot);       // of one in the background

// Their keys, in order.
std::vector<std::string> running();
bool is_running(std::string_view robot);
// The key of the one called so, or that has this key: at this router if several have the name.
// Without a name: of the only one. Throws Failure.
std::string chosen(std::string_view name, std::string_view router);
// Throws Failure: it does not run, it does not answer.
json::object ask(std::string_view robot, const json::object& question, const Signals& signals,
                 tims::Duration timeout);

}  // namespace timsctl::robot
