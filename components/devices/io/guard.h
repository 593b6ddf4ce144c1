// Sends stop commands to a device when its driver crashes.
//
// Some vehicles keep moving until they receive a stop command and have no watchdog. For these, a
// small child process holds the line to the device open. If the driver ends without releasing the
// guard (crash, kill -9, out of memory), the guard writes the stop commands to the device and ends.
// The transport has encoded them from Dialogue::stop_commands(): bytes, frames, or lines of text.
#pragma once

#include <memory>
#include <vector>

#include <sys/types.h>

#include "os/file.h"
#include "tims/result.h"

namespace rack::device {

class Guard {
 public:
  // line: descriptor of the device; the guard duplicates it.
  static tims::Result<std::unique_ptr<Guard>> start(
      int line, const std::vector<std::vector<std::byte>>& stop_commands);
  // Releases the guard, which then sends nothing.
  ~Guard();
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;

 private:
  Guard(tims::os::File alive, pid_t process) : alive_(std::move(alive)), process_(process) {}

  tims::os::File alive_;  // socket to the guard; closed without a release if the driver crashes
  pid_t process_;
};

}  // namespace rack::device
