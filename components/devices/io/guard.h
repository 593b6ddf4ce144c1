// The last words to a device whose driver dies.
//
// Some vehicles go on driving until they are told to stop, and have no watchdog of their own. So a
// small process of its own waits beside the driver, holds the line to the device open, and does
// nothing; when the driver ends without having released it (a crash, kill -9, no memory), it tells
// the device to stop, and ends. What it writes, the way to the device has made of what the dialogue
// wants to be said: bytes, frames, lines of text.
#pragma once

#include <memory>
#include <vector>

#include <sys/types.h>

#include "os/file.h"
#include "tims/result.h"

namespace rack::device {

class Guard {
 public:
  // line: of the device; only its own copy is kept.
  static tims::Result<std::unique_ptr<Guard>> start(
      int line, const std::vector<std::vector<std::byte>>& last_words);
  // Releases it: nothing is said.
  ~Guard();
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;

 private:
  Guard(tims::os::File alive, pid_t process) : alive_(std::move(alive)), process_(process) {}

  tims::os::File alive_;  // a socket to it: closed without a word when the driver dies
  pid_t process_;
};

}  // namespace rack::device
