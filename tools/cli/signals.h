// Ctrl-C as something that can be waited for. Signals are blocked while this exists and come in
// through a descriptor: no handler, no flag.
#pragma once

#include "os/file.h"
#include "tims/time.h"

namespace timsctl {

class Signals {
 public:
  Signals();  // before any thread is started: threads inherit what is blocked

  enum class Woken { kReadable, kTimeout };
  // Until `fd` can be read (-1: none), the deadline, or a signal: then throws Interrupted.
  Woken wait(int fd, tims::Time deadline) const;
  void sleep_until(tims::Time deadline) const { (void)wait(-1, deadline); }

 private:
  tims::os::File file_;
};

}  // namespace timsctl
