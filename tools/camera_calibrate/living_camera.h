// The pictures of a Camera component, one by one, through a router.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "rack/proxies/camera.h"
#include "tools/cli/connection.h"

namespace rack::camera_calibrate {

class LivingCamera {
 public:
  // `camera`: "Camera/0/0". `host`: as -H of timsctl; empty: the default router. Throws Failure: no
  // router, no such component, or it rectifies its pictures already.
  LivingCamera(const std::string& camera, const std::string& host, tims::Duration timeout,
               const timsctl::Signals& signals);

  // The next picture; valid until the next call. Throws Failure: the camera is off, or sends no
  // picture in time.
  const CameraData& next();
  [[nodiscard]] std::string name() const;

 private:
  timsctl::Message ask(std::int8_t type);
  void refuse_rectified();

  const timsctl::Signals& signals_;
  tims::Duration timeout_;
  std::unique_ptr<timsctl::Connection> connection_;
  tims::Address camera_;
  CameraData picture_;
};

}  // namespace rack::camera_calibrate
