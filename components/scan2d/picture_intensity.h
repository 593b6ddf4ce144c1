// How bright the points of a scan are in the picture of a camera that looks at them. Pure.
//
// The camera is a pinhole: a point goes through the middle of the lens onto the sensor, where the
// lens bends it a little (radial k1, k2, tangential p1, p2, in mm on the sensor); see D. C. Brown,
// "Close-range camera calibration", 1971. The robot drives on between scan and picture: points are
// looked up where they were, seen from the robot when the picture was taken.
#pragma once

#include <optional>

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
  // `mounting`: of the lens in the plane of the ladar; it looks along its x. kInvalidArgument: the
  // camera does not say what it sees.
  static tims::Result<CameraView> make(const CameraParamData& camera, const Pose& mounting);

  // Of a place in the frame of the robot, in a picture of this size. None: it is not in it.
  [[nodiscard]] std::optional<Pixel> pixel(const scan3d::Place& place, double width,
                                           double height) const;

 private:
  CameraView(const CameraParamData& camera, const Pose& mounting)
      : camera_(camera), to_camera_(scan3d::Frame(mounting).inverse()) {}

  CameraParamData camera_;
  scan3d::Frame to_camera_;
};

// Each point's intensity becomes how bright it is in the picture; 0 where it is not in it.
// `moved`: from the robot at the picture to the robot at the scan. kInvalidArgument: pixels of this
// mode are not understood, or there are too few; the scan stays as it is.
tims::Result<void> add_brightness(const CameraView& view, const CameraData& picture,
                                  const Pose& moved, Scan2dData& scan);

}  // namespace rack::scan2d
