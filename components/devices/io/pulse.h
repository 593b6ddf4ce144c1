// The pulse that a receiver gives at the beginning of each second, as the kernel has seen it: its
// interrupt takes the time, not a program that reads lines. On a serial line it is the wire DCD,
// for which somebody has said `ldattach PPS /dev/ttyS0`; on a small computer a pin (pps-gpio).
#pragma once

#include <optional>
#include <string>

#include "os/file.h"
#include "tims/result.h"
#include "tims/time.h"

namespace rack::device {

class Pulse {
 public:
  // /dev/ppsN of this serial line; where none is, the only one that belongs to no line. Empty:
  // there is neither.
  static std::string find(const std::string& serial_line);
  static tims::Result<Pulse> open(const std::string& path);

  // The last one, by the wall clock, since 1970; none: there was none yet.
  [[nodiscard]] std::optional<tims::Duration> last() const;

 private:
  explicit Pulse(tims::os::File file) : file_(std::move(file)) {}

  tims::os::File file_;
};

}  // namespace rack::device
