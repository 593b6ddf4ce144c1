// The pulse per second (PPS) of a receiver, time-stamped by an interrupt of the kernel and
// therefore more exact than reading a line. On a serial line the pulse is on DCD, after `ldattach
// PPS /dev/ttyS0`; on single-board computers it may be a GPIO pin (pps-gpio).
#pragma once

#include <optional>
#include <string>

#include "os/file.h"
#include "tims/result.h"
#include "tims/time.h"

namespace rack::device {

class Pulse {
 public:
  // The /dev/ppsN of this serial line, or else the only one that belongs to no line. Empty if there
  // is neither.
  static std::string find(const std::string& serial_line);
  static tims::Result<Pulse> open(const std::string& path);

  // Wall-clock time of the last pulse, since 1970; empty before the first one.
  [[nodiscard]] std::optional<tims::Duration> last() const;

 private:
  explicit Pulse(tims::os::File file) : file_(std::move(file)) {}

  tims::os::File file_;
};

}  // namespace rack::device
