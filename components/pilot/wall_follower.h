// Drives along walls, on and on (specification, section 10.7). Pure.
#pragma once

#include <chrono>

#include "components/pilot/joystick_drive.h"

namespace rack::pilot {

struct WallFollowerSettings {
  enum class Mode : std::uint8_t {
    kGeometric = 0,    // keeps the wall on its left at a distance
    kBraitenberg = 1,  // turns away from what is near, and goes where there is room
  };
  Mode mode = Mode::kBraitenberg;
  i32 speed_max = 500;       // mm/s
  double omega_max = 0.35;   // rad/s
  i32 distance = 1000;       // to the wall, mm
  i32 test_distance = 1000;  // beyond it a wall does not matter yet, mm
};

class WallFollower {
 public:
  WallFollower(const WallFollowerSettings& settings, const ChassisParamData& chassis)
      : settings_(settings), chassis_(chassis) {}

  // `period`: since the last scan.
  Drive follow(const Scan2dData& scan, std::chrono::milliseconds period);

 private:
  struct Wish {
    double speed = 0;  // a part of what is allowed
    double omega = 0;  // rad/s
  };
  [[nodiscard]] Wish geometric(const Scan2dData& scan) const;
  [[nodiscard]] Wish braitenberg(const Scan2dData& scan) const;
  [[nodiscard]] bool blocked(const Scan2dData& scan, i32 safe);

  WallFollowerSettings settings_;
  ChassisParamData chassis_;
  double speed_ = 0;      // of the last scan
  bool turning_ = false;  // at rest, until there is room again
};

}  // namespace rack::pilot
