// Where things in a picture are, seen from the robot: a pinhole camera at a known place on it. The
// picture must be free of distortion (`calibration` of CameraV4l). Pure.
#pragma once

#include <optional>

#include "components/geometry/pose.h"
#include "components/scan3d/frame.h"
#include "rack/proxies/camera.h"
#include "tims/result.h"

namespace rack::vision {

struct ImagePoint {
  double column = 0;  // pixels from the left edge
  double row = 0;     // pixels from the top edge
};

// Focal lengths and principal point, in pixels of the picture.
struct Lens {
  double fx = 0;
  double fy = 0;
  double cx = 0;
  double cy = 0;
};

class CameraGeometry {
 public:
  // `parameters`: the camera's answer to GET_PARAMETER. `mounting`: pose of the lens on the robot,
  // which stands on the ground at z = 0: z is negative, psi is positive if it looks up.
  // kInvalidArgument: the camera has no focal length.
  static tims::Result<CameraGeometry> make(const CameraParamData& parameters, int width, int height,
                                           const Pose& mounting);

  [[nodiscard]] const Lens& lens() const { return lens_; }

  // From the camera's frame to the robot's. The camera's has the axes of the robot's.
  [[nodiscard]] scan3d::Place on_robot(const scan3d::Place& seen) const { return mount_ * seen; }
  // Where a place in the robot's frame is in the picture; empty behind the lens.
  [[nodiscard]] std::optional<ImagePoint> pixel(const scan3d::Place& place) const;
  // The place on the ground that a pixel shows; empty above the horizon.
  [[nodiscard]] std::optional<scan3d::Place> ground(const ImagePoint& pixel) const;

 private:
  CameraGeometry(const Lens& lens, const scan3d::Frame& mount)
      : lens_(lens), mount_(mount), to_camera_(mount.inverse()) {}

  Lens lens_;
  scan3d::Frame mount_;
  scan3d::Frame to_camera_;
};

}  // namespace rack::vision
