// A transport with a stream of bytes on a file descriptor: serial lines and TCP connections. Data
// that cannot be written at once waits in a small buffer, which accepts whole pieces only.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "os/file.h"
#include "rack/devices/transport.h"

namespace rack::device {

class StreamTransport : public Transport {
 public:
  // `baud`: rate of a serial line; 0: bytes have no transmission time.
  StreamTransport(tims::os::File file, std::string description, std::uint32_t baud);

  [[nodiscard]] int descriptor() const override { return file_.get(); }
  [[nodiscard]] Time next_timeout() const override { return next_try_; }
  [[nodiscard]] std::string description() const override { return description_; }
  tims::Result<void> receive(Time now, const Receive& receive) override;
  tims::Result<bool> send(Time now, std::span<const std::byte> bytes, std::uint32_t id) override;

 protected:
  // Called when the descriptor was readable but read() returned nothing: returns an error if the
  // device is gone.
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
