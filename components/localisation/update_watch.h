// Notices that another component, such as ObjRecogMarkers, has updated the position: it is then
// elsewhere than the odometry has taken it. Pure.
#pragma once

#include <cmath>
#include <optional>

#include "components/geometry/pose.h"

namespace rack::localisation {

class UpdateWatch {
 public:
  static constexpr double kJump = 300;  // mm: smaller updates change nothing for the localisation

  // The position that was set by the caller's own update, and the odometry of the same time.
  void on_own_update(const Pose& position, const Pose& odometry) { last_ = {position, odometry}; }

  // The position and the odometry at a later time. Whether somebody else has set it since the last
  // call.
  bool is_updated(const Pose& position, const Pose& odometry) {
    const std::optional<Both> before = last_;
    last_ = {position, odometry};
    if (!before) return false;
    const Pose expected = before->position + (odometry - before->odometry);
    return std::hypot(position.x - expected.x, position.y - expected.y) > kJump;
  }

 private:
  struct Both {
    Pose position;
    Pose odometry;
  };
  std::optional<Both> last_{};
};

}  // namespace rack::localisation
