// Where a vehicle is by how it has moved: in the frame of its odometry, and in the world by a
// position that was known once (specification, sections 10.2 and 10.5). Pure.
#pragma once

#include <chrono>

#include "components/geometry/pose.h"
#include "rack/proxies/chassis.h"
#include "rack/proxies/odometry.h"
#include "rack/proxies/position.h"

namespace rack::navigation {

// --- In the frame of its odometry
//
// Each movement is relative to the vehicle as it was: it is turned by the heading so far, and
// added. Between two data sets the vehicle is taken to move at an even speed; angles go the short
// way round.
class DeadReckoning {
 public:
  explicit DeadReckoning(const Pose& start) : pose_(start) {}

  void reset() { pose_ = {}; }
  // Movements that are no numbers are left out.
  OdometryData add(const ChassisData& movement);

 private:
  Pose pose_;
};

// At `time`, between two data sets or on the straight line beyond them. A position is as uncertain
// as the less certain of both.
OdometryData interpolated(const OdometryData& before, const OdometryData& after, TimeStamp time);
PositionData interpolated(const PositionData& before, const PositionData& after, TimeStamp time);

// --- In the world
//
// Odometry knows well how the vehicle has moved, and badly where it is: it has a frame of its own
// that drifts. What is kept is where that frame lies in the world: the pose that was known, beside
// the pose that the odometry had at that moment. The position is the known pose plus the movement
// since, turned into the world. With each millimetre and each radian the standard deviation grows.
// A new known pose moves the frame; so that nobody who steers by it sees a jump, the position goes
// from the old frame to the new one in a straight line during the time of blending.

// How fast a position becomes uncertain.
struct Drift {
  double x = 50;  // mm for each metre along x
  double y = 50;  // and y; a fifth of it for each metre across
};

class PositionTracker {
 public:
  PositionTracker(const Drift& drift, std::chrono::milliseconds blending)
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
