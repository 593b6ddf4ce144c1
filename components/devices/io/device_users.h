// Which processes have device files open.
#pragma once

#include <map>
#include <string>

namespace rack::device {

// "/dev/ttyACM0" -> "LadarHokuyoUrg (pid 4711)". Only root sees the files of other users'
// processes. `proc`: another directory than /proc, for tests.
std::multimap<std::string, std::string> device_users(const std::string& proc = "/proc");

}  // namespace rack::device
