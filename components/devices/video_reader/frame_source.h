// Where frames come from: a video that OpenCV reads, or a folder of pictures.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "components/devices/core/video_frame.h"
#include "rack/devices/device_address.h"
#include "tims/time.h"

namespace rack::device {

struct SourceFrame {
  VideoHead head{};
  std::span<const std::byte> bytes{};  // valid until the next frame
  tims::Duration media{};              // since the beginning of a file
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;
  // Waits for the next frame; false at the end. After an error the source is lost.
  virtual Result<bool> next(SourceFrame& frame) = 0;
  // Format, size and rate, as far as they are known.
  [[nodiscard]] virtual std::string description() const = 0;
};

// --- capture_source.cpp

// A video file, a stream or a pipeline. Blocks until the source has answered: other programs limit
// that for pipelines, which may block for ever.
Result<std::unique_ptr<FrameSource>> open_capture(const DeviceAddress& address);

// --- folder_source.cpp

// Pictures of a folder, sorted by name.
Result<std::unique_ptr<FrameSource>> open_folder(const DeviceAddress& address);

}  // namespace rack::device
