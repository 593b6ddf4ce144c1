// Pictures of a calibration board and of straight lines as a known camera sees them, with the
// distortion of its lens, noise and blur. The lens is inverted here by a fixed-point iteration, not
// by OpenCV, which is what the pictures are for. Library `rendered_board`.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "components/pictures/camera_calibration.h"
#include "tools/camera_calibrate/board.h"

namespace tims::test {

// Of the board's points in the frame of the camera (x right, y down, z ahead), mm and rad.
struct BoardPose {
  double x = 0, y = 0, z = 0;                 // of the middle of the board
  double turn_x = 0, turn_y = 0, turn_z = 0;  // about its axes: R = Rz * Ry * Rx
};

struct PictureFaults {
  double noise = 0;  // standard deviation of a grey value
  int blur = 0;      // passes of a filter 1 2 1 in both directions
  std::uint32_t seed = 1;
};

class RenderedCamera {
 public:
  // Each pixel is the mean of `samples` x `samples` rays.
  explicit RenderedCamera(rack::pictures::CameraCalibration calibration, int samples = 3);

  // Grey values of width * height pixels. `brightness`: of the direction x, y, 1 in front of the
  // camera, 0 (black) to 1.
  using Brightness = std::function<double(double x, double y)>;
  [[nodiscard]] std::vector<std::byte> render(const Brightness& brightness,
                                              const PictureFaults& faults = {}) const;
  [[nodiscard]] std::vector<std::byte> render(const rack::camera_calibrate::Board& board,
                                              const BoardPose& pose,
                                              const PictureFaults& faults = {}) const;

  // The pixel at which a point is seen, and whether the whole board is in the picture.
  [[nodiscard]] std::array<double, 2> pixel_of(double x, double y, double z) const;
  // The pixels at which the board's points are seen.
  [[nodiscard]] std::vector<rack::camera_calibrate::PicturePoint> seen(
      const rack::camera_calibrate::Board& board, const BoardPose& pose) const;
  [[nodiscard]] bool shows(const rack::camera_calibrate::Board& board, const BoardPose& pose) const;
  // Poses in which the whole board is seen: in all parts of the picture, tilted by up to `tilt`
  // rad. The same for the same seed.
  [[nodiscard]] std::vector<BoardPose> poses(const rack::camera_calibrate::Board& board,
                                             std::size_t count, double tilt,
                                             std::uint32_t seed = 1) const;

  [[nodiscard]] const rack::pictures::CameraCalibration& calibration() const {
    return calibration_;
  }

 private:
  struct Ray {
    float x;
    float y;
  };
  rack::pictures::CameraCalibration calibration_;
  int samples_;
  std::vector<Ray> rays_;  // samples of a pixel one after another
};

// A portable graymap, which camera-calibrate reads.
std::string pgm_of(const std::vector<std::byte>& pixels, int width, int height);

}  // namespace tims::test
