// Going on in the background.
#pragma once

#include <functional>
#include <string>

#include "tools/timsctl/exit_code.h"

namespace timsctl {

// Runs `work` in a process of its own, and returns when that has called `ready` (kDone) or has
// ended (its exit status). From `ready` on, what it says goes to the file `log`. Throws Failure
// when the system has no room for a process. Before any thread is started.
Exit run_detached(const std::string& log,
                  const std::function<Exit(const std::function<void()>& ready)>& work);

}  // namespace timsctl
