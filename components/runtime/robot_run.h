// What the programs of a robot that `timsctl up` has started have in common on one host: a folder
// that exists while the robot runs, named by $RACK_RUN.
#pragma once

#include <string_view>

namespace rack {

// Whether this program is the first of its robot that reports `what`, a short name: a remark that
// concerns all of them is made once. Always true without that folder.
bool first_of_robot(std::string_view what);

}  // namespace rack
