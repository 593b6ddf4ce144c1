// Parameter "calibration" of a camera driver: the file of the intrinsics, and what GET_PARAMETER
// reports of rectified pictures. It is read in the data task and reported by the command task.
#pragma once

#include <mutex>
#include <optional>
#include <string>

#include "components/devices/camera/camera_intrinsics.h"
#include "components/pictures/camera_calibration.h"
#include "os/file.h"
#include "tims/result.h"

namespace rack::device {

class CalibratedCamera {
 public:
  // When the camera is turned on. Errors name the file.
  tims::Result<pictures::CameraCalibration> load(const std::string& file) {
    auto text = tims::os::read_file(file, pictures::kCalibrationFileMax + 1);
    if (!text)
      return tims::Error(tims::Errc::kInvalidArgument, "calibration=" + text.error().detail());
    auto calibration = pictures::read_calibration(*text);
    if (!calibration)
      return tims::Error(tims::Errc::kInvalidArgument,
                         "calibration=" + file + ": " + calibration.error().detail());
    const std::lock_guard lock(mutex_);
    file_ = file;
    calibration_ = *calibration;
    width_ = height_ = 0;
    return calibration;
  }

  // The size of the pictures, which the camera chooses.
  void set_size(std::int32_t width, std::int32_t height) {
    const std::lock_guard lock(mutex_);
    width_ = width;
    height_ = height;
  }

  // Of the pictures that are sent; before the first one, of this size. The file must be that of the
  // parameter when it was read: this function is called by a task that must not wait for a disk.
  tims::Result<CameraParamData> intrinsics(const std::string& file, std::int32_t width,
                                           std::int32_t height) const {
    const std::lock_guard lock(mutex_);
    if (!calibration_ || file != file_)
      return tims::Error(tims::Errc::kInvalidArgument,
                         "the calibration is read when the camera is turned on");
    const bool has_pictures = width_ > 0;
    return rectified_intrinsics(*calibration_, has_pictures ? width_ : width,
                                has_pictures ? height_ : height);
  }

 private:
  mutable std::mutex mutex_;
  std::string file_;
  std::optional<pictures::CameraCalibration> calibration_;
  std::int32_t width_ = 0;  // 0: no picture yet
  std::int32_t height_ = 0;
};

}  // namespace rack::device
