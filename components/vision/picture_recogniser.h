// What components have in common that recognise objects in the pictures of a camera: they receive
// the pictures, know where the camera is on the robot, and where the robot was at the time of each.
#pragma once

#include <array>
#include <optional>

#include "components/vision/camera_geometry.h"
#include "components/vision/grey_frame.h"
#include "rack/data_module.h"
#include "rack/data_of_time.h"
#include "rack/input.h"
#include "rack/proxies/camera.h"
#include "rack/proxies/obj_recog.h"
#include "rack/proxies/position.h"

namespace rack::vision {

// Of every such component; those of its own follow.
inline constexpr std::array<ParameterInfo, 10> kPictureParameters = {{
    required_partner("camera", "the camera"),
    optional_partner("position", "the position", "the position of the robot; -1: none"),
    {"period", 200, "between the pictures that are searched, at least [ms]", 1, 60000},
    {"cameraX", 0, "position of the lens on the robot, forward [mm]"},
    {"cameraY", 0, "the same to the right [mm]"},
    {"cameraHeight", 500, "above the ground [mm]", 1, 1e5},
    {"cameraPhi", 0.0F, "roll of the camera to the right [deg]", -360, 360},
    {"cameraPsi", 0.0F, "pitch of the camera upwards [deg]", -360, 360},
    {"cameraRho", 0.0F, "heading of the camera, clockwise [deg]", -360, 360},
    {"cameraLag", 0, "delay of the time stamps of pictures [ms]", 0, 10000},
}};

class PictureRecogniser : public DataModule<ObjRecogData> {
 protected:
  explicit PictureRecogniser(const ModuleInfo& info);

  Result<void> module_on() override;
  void module_off() override;
  Result<void> module_loop() override;

  // Fills `objects`, which have their time and the position of the robot, in the robot's frame.
  // `at`: the position of the robot at the time of the picture, if it has a partner for it.
  virtual Result<void> recognise(const GreyView& picture, const CameraGeometry& camera,
                                 const std::optional<PositionData>& at, ObjRecogData& objects) = 0;

  Partner<PositionProxy>& position() { return position_; }

 private:
  [[nodiscard]] Pose mounting() const;
  Result<void> adapt_to(const GreyView& picture);

  OwnMailbox work_{*this, 1, 512};
  Input<CameraProxy> camera_{*this, "camera", work_, 2, body_max<CameraData>()};
  Partner<PositionProxy> position_{*this, "position", work_};
  DataOfTime<PositionProxy> position_then_;
  CameraData picture_;
  GreyFrame grey_;
  CameraParamData lens_;
  int width_ = 0;  // of the pictures that `geometry_` is for
  int height_ = 0;
  std::optional<CameraGeometry> geometry_;
  int misses_ = 0;
};

}  // namespace rack::vision
