// Which poses from markers are sent to Position.
//
// A pose near the believed one is sent at once, if it is more certain than that; of two that fit
// equally, none. One elsewhere is either a wrong marker, or the robot was carried away: it is sent
// when all pictures of two seconds have agreed on it, while the movement between them is that of
// the odometry. A single marker may have been moved itself: as long as the position is certain and
// the robot stands, it takes longer. Pure.
#pragma once

#include <chrono>
#include <optional>
#include <span>

#include "components/vision/robot_fix.h"

namespace rack::vision {

class FixGate {
 public:
  static constexpr int kAgreeing = 5;  // pictures in succession, at least
  static constexpr std::chrono::seconds kAgreeingFor{2};
  static constexpr std::chrono::seconds kSingleAgreesFor{5};
  static constexpr double kUncertain = 1000;  // mm: the position does not know where the robot is
  static constexpr double kMoved = 200;       // mm
  static constexpr double kTurned = radians(15);

  // `fixes`: of one picture, as from fixes_of(). `believed` and `deviation` (mm): of Position at
  // the time of the picture.
  std::optional<RobotFix> take(TimeStamp time, std::span<const RobotFix> fixes,
                               const Pose& believed, double deviation);

 private:
  struct Elsewhere {
    TimeStamp began;
    Pose start;     // believed at the first picture
    Pose pose;      // of the last picture
    Pose believed;  // at that time
    int pictures = 1;
  };

  std::optional<RobotFix> elsewhere(TimeStamp time, const RobotFix& fix, const Pose& believed,
                                    double deviation);

  std::optional<Elsewhere> elsewhere_{};
};

}  // namespace rack::vision
