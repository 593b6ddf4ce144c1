#include "components/runtime/robot_run.h"

#include <cerrno>
#include <string>

#include <fcntl.h>

#include "os/environment.h"
#include "os/file.h"

namespace rack {

// The file is the memory: it is removed when the robot is started again (tools/robot).
bool first_of_robot(std::string_view what) {
  const std::string folder = tims::os::environment("RACK_RUN");
  if (folder.empty()) return true;
  const std::string path = (folder + "/reported-").append(what);
  const tims::os::File mark(
      ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600));
  return mark || errno != EEXIST;
}

}  // namespace rack
