// What surrounds a program: the variables it was started with, the programs beside it, and the
// service manager that wants to hear how it does, by datagrams to $NOTIFY_SOCKET as sd_notify(3)
// describes them.
#pragma once

#include <cstdlib>
#include <string>
#include <string_view>

#include "os/file.h"

namespace tims::os {

// Empty: not set, or set to nothing.
inline std::string environment(const char* name) {
  const char* text = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
  return text == nullptr ? "" : text;
}

// A program of that name beside this one, so that a build's programs start the build's others, or
// where an installation has its programs; else the name as it is, for PATH.
std::string find_program(const std::string& name);

class ServiceManager {
 public:
  // Empty: nobody listens, and what is told goes nowhere. A name that begins with @ is abstract.
  explicit ServiceManager(std::string path);

  static ServiceManager of_environment();

  [[nodiscard]] bool listens() const { return !path_.empty(); }
  // "READY=1", "STATUS=on". Never waits: a manager that does not read is no reason to.
  void tell(std::string_view text) const;

 private:
  std::string path_;
  File socket_;
};

}  // namespace tims::os
