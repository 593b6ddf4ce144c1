// What a command's end means to a script. One table for all commands.
#pragma once

namespace timsctl {

enum class Exit : int {
  kDone = 0,           // done; the answer is yes
  kNo = 1,             // the answer is no, a check failed, a component said ERROR
  kUsage = 2,          // the command line is wrong
  kNoRouter = 3,       // no router there, or not reachable
  kNoSuch = 4,         // no such address, key, code
  kDenied = 5,         // the system or the router refused
  kTimeout = 6,        // no answer in time, or only a part of it
  kVersion = 7,        // the two sides do not speak the same protocol
  kInterrupted = 130,  // Ctrl-C before it was done
};

}  // namespace timsctl
