// The line of an emulated device: a pseudo terminal with the rate of a serial line, a listening TCP
// port, or the same transport that drivers use (CAN, UDP).
#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "os/file.h"
#include "rack/devices/transport.h"

namespace rack::device {

// Addresses: "pty:/tmp/lms", "pty:/tmp/bus?can=500000" (CAN devices behind an SLCAN adapter),
// "tcp:127.0.0.1:2111" (listens), "can:vcan0", "udp:127.0.0.1:2368".
tims::Result<std::unique_ptr<Transport>> open_line(const DeviceAddress& address,
                                                   std::uint32_t baud);

// Limits bytes to the rate of a line, ten bits each. A byte passes only after its last bit was on
// the line.
class Pace {
 public:
  // Number of the `waiting` bytes that may pass now. `baud` 0: all of them.
  std::size_t allowed(Time now, std::size_t waiting, std::uint32_t baud);
  // When the next byte may pass.
  [[nodiscard]] Time next() const { return next_; }

 private:
  Time carried_{};  // when the line finished with the bytes that have passed
  bool is_idle_ = true;
  Time next_{};
};

}  // namespace rack::device
