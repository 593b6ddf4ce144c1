// Which poses from markers are sent to Position.
//
// A pose near the believed one is sent at once. One elsewhere is either a wrong marker, or the
// robot was carried away: it is sent when several pictures in succession have agreed on it, while
// the movement between them is that of the odometry. Pure.
#pragma once

#include <optional>
#include <span>

#include "components/vision/robot_fix.h"

namespace rack::vision {

class FixGate {
 public:
  static constexpr int kAgreeing = 5;  // pictures in succession

  // `fixes`: of one picture, as from fixes_of(). `believed` and `deviation` (mm): of Position at
  // the time of the picture.
  std::optional<RobotFix> take(std::span<const RobotFix> fixes, const Pose& believed,
                               double deviation);

 private:
  struct Elsewhere {
    Pose pose;      // of the last picture
    Pose believed;  // at that time
    int pictures = 1;
  };

  std::optional<RobotFix> elsewhere(const RobotFix& fix, const Pose& believed);

  std::optional<Elsewhere> elsewhere_{};
};

}  // namespace rack::vision
