// Environment of a program: its variables, the programs installed next to it, and the service
// manager, which receives status datagrams at $NOTIFY_SOCKET as sd_notify(3) describes.
#pragma once

#include <cstdlib>
#include <string>
#include <string_view>

#include "os/file.h"

namespace tims::os {

// Returns an empty text when the variable is not set or is empty.
inline std::string environment(const char* name) {
  const char* text = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
  return text == nullptr ? "" : text;
}

// Path of a program with this name: in the directory of this program (so that programs of one build
// start each other), else where an installation has its programs; else the name itself, to be found
// through PATH.
std::string find_program(const std::string& name);

class ServiceManager {
 public:
  // Empty path: there is no service manager, and messages are discarded. A name that begins with @
  // is abstract.
  explicit ServiceManager(std::string path);

  static ServiceManager of_environment();

  [[nodiscard]] bool listens() const { return !path_.empty(); }
  // Sends "READY=1", "STATUS=on". Never waits, even if the manager does not read.
  void tell(std::string_view text) const;

 private:
  std::string path_;
  File socket_;
};

}  // namespace tims::os
