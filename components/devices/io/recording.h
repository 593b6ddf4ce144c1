// A file of what once came from a device, record by record: captures, candump logs, packet captures
// (payloads of UDP and TCP), raw bytes; or a folder of pictures, as a camera's frames.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "components/devices/core/device_address.h"
#include "components/recordings/capture.h"

namespace rack::device {

class Recording {
 public:
  virtual ~Recording() = default;
  // False: the end.
  virtual Result<bool> next(CaptureRecord& record) = 0;
  virtual void rewind() = 0;
};

// Of "play:FILE". `baud`: the pace of raw bytes.
Result<std::unique_ptr<Recording>> open_recording(const DeviceAddress& address, std::uint32_t baud);

// Record by record to its end. Returns how many cannot be read: of a program that died, the last
// line is cut. kSystem: there is no such file; else what `take` says, with where that is.
Result<std::uint64_t> read_recording(const std::string& path,
                                     const std::function<Result<void>(const CaptureRecord&)>& take);

}  // namespace rack::device
