// Robots that run on this host: a folder for each, with the socket at which its timsctl listens.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tools/timsctl/json.h"
#include "tools/timsctl/signals.h"

namespace timsctl::robot {

std::string folder_of(std::string_view robot);
std::string control_socket(std::string_view robot);
std::string status_socket(std::string_view robot);  // where its components say how they are
std::string log_file(std::string_view robot);       // of one in the background

// Their names, in order.
std::vector<std::string> running();
bool is_running(std::string_view robot);
// Throws Failure: it does not run, it does not answer.
json::object ask(std::string_view robot, const json::object& question, const Signals& signals,
                 tims::Duration timeout);

}  // namespace timsctl::robot
