// The calibration of a camera, and its file in the format of ROS (camera_info, camera_calibration):
// YAML with the camera matrix, the distortion of the lens, and the camera matrix of rectified
// pictures. Pure; yaml-cpp reads and writes it.
//
// A point X, Y, Z in front of the camera is seen at x = fx * X/Z + cx, y = fy * Y/Z + cy, after the
// lens has displaced X/Z and Y/Z. A pixel with integer coordinates is meant at its centre.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tims/result.h"

namespace rack::pictures {

struct CameraMatrix {
  double fx = 0;  // focal length, pixels
  double fy = 0;
  double cx = 0;  // principal point, pixels
  double cy = 0;

  bool operator==(const CameraMatrix&) const = default;
};

struct CameraCalibration {
  std::int32_t width = 0;  // of the pictures it was made with, pixels
  std::int32_t height = 0;
  std::string name{};
  CameraMatrix camera{};
  // k1, k2, p1, p2, k3 (plumb_bob), or with k4, k5, k6 (rational_polynomial).
  std::vector<double> distortion{};
  std::array<double, 9> rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1};  // of rectified pictures
  CameraMatrix rectified{};
  std::array<double, 3> shift{};  // fourth column of projection_matrix; of stereo cameras only

  bool operator==(const CameraCalibration&) const = default;
};

inline constexpr std::size_t kCalibrationFileMax = 64 << 10;  // bytes; a file has some hundred
inline constexpr std::int32_t kCalibrationSideMax = 32766;    // pixels; OpenCV's limit

// At most 100 printable ASCII characters.
bool is_camera_name(std::string_view name);

// Error kMalformed: "line 3: ...". Unknown keys are ignored. rectification_matrix and
// projection_matrix may be omitted: rectified pictures then have the camera matrix.
tims::Result<CameraCalibration> read_calibration(std::string_view text);

// The reverse. `remark`: becomes comments at the beginning; may have several lines.
std::string to_yaml(const CameraCalibration& calibration, std::string_view remark = {});

// The calibration for pictures of another size that show the same area.
CameraCalibration scaled(const CameraCalibration& calibration, std::int32_t width,
                         std::int32_t height);
// The same. kInvalidArgument: the aspect ratio differs, so that the area cannot be the same.
tims::Result<CameraCalibration> calibration_for(const CameraCalibration& calibration,
                                                std::int32_t width, std::int32_t height);

}  // namespace rack::pictures
