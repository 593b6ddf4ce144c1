// The brightness of the points of a scan in a camera image, by OpenCV (projectPoints, cvtColor).
// Pure. Built without OpenCV, CameraView::make() reports that.
//
// Pinhole camera with lens distortion (radial k1, k2, tangential p1, p2, in mm on the sensor); see
// D. C. Brown, "Close-range camera calibration", 1971. The robot moves between scan and image:
// points are projected from their positions relative to the robot at the time of the image.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "components/geometry/pose.h"
#include "components/scan3d/frame.h"
#include "rack/proxies/camera.h"
#include "rack/proxies/scan2d.h"
#include "tims/result.h"

namespace rack::scan2d {

struct Pixel {
  std::size_t column = 0;
  std::size_t row = 0;
};

class CameraView {
 public:
  // `mounting`: pose of the lens relative to the plane of the ladar; it looks along its x.
  // kInvalidArgument: the camera has no focal length.
  static tims::Result<CameraView> make(const CameraParamData& camera, const Pose& mounting);

  // The pixels of points in the frame of the robot, for an image of this size. None: outside of the
  // image. They are valid until the next call.
  tims::Result<std::span<const std::optional<Pixel>>> pixels(std::span<const scan3d::Place> places,
                                                             double width, double height);

  // Sets the intensity of each point to its brightness in the image; 0 outside of it. `moved`: pose
  // of the robot at the scan, relative to that at the image. kInvalidArgument: the pixel format is
  // not supported, or the image is too short; the scan is not changed.
  tims::Result<void> add_brightness(const CameraData& picture, const Pose& moved, Scan2dData& scan);

 private:
  CameraView(const CameraParamData& camera, const Pose& mounting)
      : camera_(camera), to_camera_(scan3d::Frame(mounting).inverse()) {}

  void project(double width, double height);

  CameraParamData camera_;
  scan3d::Frame to_camera_;
  // Of the points: where they are, in OpenCV's axes; on the image; the pixels, and their values.
  std::vector<scan3d::Place> places_{};
  std::vector<std::array<double, 3>> seen_{};
  std::vector<std::array<double, 2>> projected_{};
  std::vector<std::optional<Pixel>> pixels_{};
  std::vector<std::byte> colours_{};
  std::vector<std::byte> greys_{};
};

}  // namespace rack::scan2d
