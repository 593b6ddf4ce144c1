// Base of the drivers of cameras: GET_PARAMETER, and SET_FORMAT while the component is on.
//
// The format is valid until one of its parameters is set or the program ends. While the component
// is on, the next picture has the new format. Negative values leave a setting unchanged: the
// original's GUI sets either the size or the mode.
#pragma once

#include <mutex>
#include <optional>
#include <utility>

#include "components/devices/camera/camera_frames.h"
#include "rack/devices/driver.h"

namespace rack::device {

struct CameraFormat {
  i32 width = 0;  // of the pictures that are published
  i32 height = 0;
  u16 mode = 0;

  bool operator==(const CameraFormat&) const = default;
};

class CameraDriver : public Driver<CameraData, CameraFrames> {
 protected:
  // Pictures are large and only the newest is of interest.
  explicit CameraDriver(const ModuleInfo& info) : Driver(info, {.history = 4}) {}

  // The format given by the parameters. The error names the modes.
  [[nodiscard]] virtual Result<CameraFormat> of_parameters() const = 0;
  // The next format that the camera can provide, or why it cannot.
  [[nodiscard]] virtual Result<CameraFormat> possible(const CameraFormat& format) const = 0;
  [[nodiscard]] virtual Result<CameraParamData> calibration() const = 0;

  // The format of SET_FORMAT, or of the parameters.
  [[nodiscard]] Result<CameraFormat> wanted() const {
    auto format = of_parameters();
    const std::lock_guard lock(format_mutex_);
    if (asked_ && asked_over_ == (format ? std::optional(*format) : std::nullopt)) return *asked_;
    return format;
  }

  Result<void> module_loop() override {
    bool is_changed = false;
    {
      const std::lock_guard lock(format_mutex_);
      is_changed = std::exchange(is_changed_, false);
    }
    if (is_changed)
      if (auto opened = open_device(); !opened) return opened;
    return Driver::module_loop();
  }

  Result<void> module_command(const tims::MessageView& message) override {
    switch (message.header.type) {
      case CameraType::kGetParameter: {
        const auto data = calibration();
        if (!data) return data.error();
        reply(message.header, CameraType::kParameter, *data);
        return {};
      }
      case CameraType::kSetFormat: {
        const auto asked = decode<CameraFormatData>(message);
        if (!asked) return asked.error();
        return answered_later(message, [this, asked = *asked] { return set_format(asked); });
      }
      default:
        return Driver::module_command(message);
    }
  }

 private:
  // By the worker: possible() asks the camera.
  Result<void> set_format(const CameraFormatData& asked) {
    const auto present = wanted();
    if (!present) return present.error();
    CameraFormat format = *present;
    if (asked.width >= 0) format.width = asked.width;
    if (asked.height >= 0) format.height = asked.height;
    if (asked.mode >= 0) format.mode = static_cast<u16>(asked.mode);
    if (asked.mode > 0xFFFF || depth_of(format.mode) == 0)
      return refused("mode " + std::to_string(asked.mode) + " is not supported by this camera");
    if (format.width < 1 || format.height < 1 || format.width > 0xFFFF || format.height > 0xFFFF)
      return refused("width and height must be 1 to 65535 pixels");
    if (format.mode != camera_mode::kJpeg && asked.depth > 0 &&
        asked.depth != depth_of(format.mode))
      return refused(std::string(name_of_mode(format.mode)) +
                     " requires depth=" + std::to_string(depth_of(format.mode)));
    const auto nearest = possible(format);
    if (!nearest) return nearest.error();
    const auto over = of_parameters();
    {
      const std::lock_guard lock(format_mutex_);
      asked_ = *nearest;
      asked_over_ = over ? std::optional(*over) : std::nullopt;
      is_changed_ = true;
    }
    wake();
    return {};
  }

  mutable std::mutex format_mutex_;
  std::optional<CameraFormat> asked_;       // requested by SET_FORMAT
  std::optional<CameraFormat> asked_over_;  // format of the parameters at that time
  bool is_changed_ = false;
};

}  // namespace rack::device
