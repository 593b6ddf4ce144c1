// Where an emulator's device ends: a pseudo terminal with the rate of a serial line, a TCP port, or
// a transport as drivers have it (CAN, UDP).
#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "components/devices/io/transport.h"
#include "os/file.h"

namespace rack::device {

// "pty:/tmp/lms", "pty:/tmp/bus?can=500000" (motors behind an adapter that speaks text),
// "tcp:127.0.0.1:2111" (listens there), "can:vcan0", "udp:127.0.0.1:2368".
tims::Result<std::unique_ptr<Transport>> open_line(const DeviceAddress& address,
                                                   std::uint32_t baud);

// Lets bytes pass no faster than a line does, ten bits each, and no sooner: none before its last
// bit was on the line.
class Pace {
 public:
  // How many of `waiting` bytes may go now. `baud` 0: all of them.
  std::size_t allowed(Time now, std::size_t waiting, std::uint32_t baud);
  // When the next may.
  [[nodiscard]] Time next() const { return next_; }

 private:
  Time carried_{};  // the line has carried what went, until then
  bool is_idle_ = true;
  Time next_{};
};

}  // namespace rack::device
