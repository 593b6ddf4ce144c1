// A position in the world: one that was known once, and the movement since (specification, section
// 10.5). Pure.
#pragma once

#include <chrono>

#include "components/geometry/pose.h"
#include "rack/proxies/odometry.h"
#include "rack/proxies/position.h"

namespace rack::navigation {

// How fast a position becomes uncertain.
struct Drift {
  double x = 50;  // mm for each metre along x
  double y = 50;  // and y; a fifth of it for each metre across
};

class Reference {
 public:
  Reference(const Drift& drift, std::chrono::milliseconds blending)
      : drift_(drift), blending_(blending) {}

  // The odometry of the place where it is: at first the origin of the world, and where it was when
  // it begins again, whatever the odometry has done meanwhile.
  void begin(const Drift& drift, std::chrono::milliseconds blending, const OdometryData& odometry);

  // Where it is now. Without begin() the world is where the odometry began.
  PositionData follow(const OdometryData& odometry);

  // It was at `known` when the odometry said `then`. With blending, what follow() says goes there
  // bit by bit.
  void update(const PositionData& known, const OdometryData& then);

 private:
  // Where the frame of the odometry lies in the world.
  struct Frame {
    Pose world{};
    Pose odometry{};
    [[nodiscard]] Pose at(const Pose& now) const { return world + (now - odometry); }
  };
  struct Deviation {
    double x = 0;
    double y = 0;
    double rho = 0;
  };
  void grow(const Pose& from, const Pose& to);

  Drift drift_;
  std::chrono::milliseconds blending_;
  Frame frame_;
  Frame earlier_;  // left behind bit by bit
  bool blends_ = false;
  TimeStamp updated_ = 0;
  bool followed_ = false;
  OdometryData newest_{};
  Pose said_{};                   // by the last follow()
  Position3d known_deviation_{};  // z, phi and psi stay as they were known
  Deviation deviation_;
};

}  // namespace rack::navigation
