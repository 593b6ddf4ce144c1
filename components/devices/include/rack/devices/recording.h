// Reads a recording of a device record by record: captures, candump logs, packet captures (payloads
// of UDP and TCP), raw bytes, or a folder of pictures as the frames of a camera.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "rack/devices/capture.h"
#include "rack/devices/device_address.h"

#pragma GCC visibility push(default)  // exported by librack-devices.so
namespace rack::device {

class Recording {
 public:
  virtual ~Recording() = default;
  // Returns false at the end.
  virtual Result<bool> next(CaptureRecord& record) = 0;
  virtual void rewind() = 0;
  // For the user, for example "candump log".
  [[nodiscard]] virtual std::string format() const = 0;
  // For the user: what of the file was left out so far, and why, and what to choose; empty if there
  // is nothing to state.
  [[nodiscard]] virtual std::string remarks() const { return {}; }
};

// Opens the file of an address "play:FILE". `baud`: rate at which raw bytes are played; 0: they are
// refused unless the address has a rate.
Result<std::unique_ptr<Recording>> open_recording(const DeviceAddress& address, std::uint32_t baud);

// Passes all records of a capture to `take`. Returns the number of unreadable lines: if the
// recording program crashed, the last line is incomplete. Fails with kSystem if the file cannot be
// opened, or with the error of `take` and its position in the file.
Result<std::uint64_t> read_recording(const std::string& path,
                                     const std::function<Result<void>(const CaptureRecord&)>& take);

}  // namespace rack::device

#pragma GCC visibility pop
