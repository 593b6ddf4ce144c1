// A device whose bytes come through a file: serial lines, TCP connections. What cannot be written
// at once waits in a small buffer, whole pieces or none.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "components/devices/io/transport.h"
#include "os/file.h"

namespace rack::device {

class StreamTransport : public Transport {
 public:
  // `baud`: of a serial line; 0: its bytes take no time.
  StreamTransport(tims::os::File file, std::string description, std::uint32_t baud);

  [[nodiscard]] int descriptor() const override { return file_.get(); }
  [[nodiscard]] Time next_timeout() const override { return next_try_; }
  [[nodiscard]] std::string description() const override { return description_; }
  tims::Result<void> receive(Time now, const Receive& receive) override;
  tims::Result<bool> send(Time now, std::span<const std::byte> bytes, std::uint32_t id) override;

 protected:
  // Nothing could be read although the file said so: an error when the device is gone.
  virtual tims::Result<void> on_end() = 0;

  tims::os::File file_;
  std::uint32_t baud_;

 private:
  tims::Result<void> write_waiting(Time now);

  std::string description_;
  std::vector<std::byte> bytes_;
  std::vector<std::byte> waiting_;
  Time next_try_ = tims::kNever;
};

}  // namespace rack::device
