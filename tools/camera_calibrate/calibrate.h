// The calibration of a camera from views of a board, by OpenCV (Z. Zhang, "A flexible new technique
// for camera calibration", 2000). Pure.
//
// The positions of the board, the camera matrix and the distortion are found that minimise the
// distances between the points that were seen and those that the camera should see, the residuals.
// A wrong result also has small residuals if the views do not determine it: such views are refused.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "components/pictures/camera_calibration.h"
#include "tools/camera_calibrate/views.h"

namespace rack::camera_calibrate {

inline constexpr std::size_t kCalibrationViewsMin = 6;
inline constexpr std::size_t kCalibrationViewsMax = 500;

struct CalibrationSettings {
  bool has_k3 = false;  // also determine k3: for wide lenses
  double keep = 0;      // 0: rectified pictures without border, 1: with all pixels of the camera's
};

// Seen minus expected position, pixels.
struct Residual {
  PicturePoint at{};
  double x = 0;
  double y = 0;
};

struct CalibratedView {
  std::string name{};
  double error = 0;  // root of the mean of the squared residuals, pixels
  bool is_outlier = false;
  std::vector<Residual> residuals{};
};

struct Calibrated {
  pictures::CameraCalibration calibration{};
  double error = 0;                      // of all views, pixels
  pictures::CameraMatrix uncertainty{};  // standard deviations
  double covered = 0;                    // part of the picture in which points were seen
  std::vector<CalibratedView> views{};
  std::vector<std::string> warnings{};
};

// All views are of pictures of the same size. kInvalidArgument: the views do not determine the
// camera; the text states what to do.
tims::Result<Calibrated> calibrate(std::span<const View> views, const Board& board, int width,
                                   int height, const CalibrationSettings& settings = {});

}  // namespace rack::camera_calibrate
