// Dead reckoning: the pose of a vehicle from its movements, in the frame of its odometry and in the
// world, relative to a known position (specification, sections 10.2 and 10.5). Pure.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "components/geometry/pose.h"
#include "rack/proxies/chassis.h"
#include "rack/proxies/odometry.h"
#include "rack/proxies/position.h"

namespace rack::navigation {

// --- In the frame of its odometry
//
// Each movement is relative to the vehicle's previous pose: it is rotated by the heading and added.
// Between two data sets constant speed is assumed; angles take the shorter arc.
//
// Data may get lost, and the movement they contain with them. A movement and the speed state how
// long the movement took; if that is less than the time since the previous data, the vehicle has
// moved meanwhile, with about the mean of both speeds.
class DeadReckoning {
 public:
  // Data that wait while the component does not run, at any period of a chassis.
  static constexpr std::uint32_t kDataWaiting = 64;
  static constexpr std::chrono::milliseconds kLongestGap{5000};  // longer ones are not estimated

  explicit DeadReckoning(const Pose& start) : pose_(start) {}

  void reset() { pose_ = {}; }
  // Ignores movements that are not numbers.
  OdometryData add(const ChassisData& movement);

 private:
  [[nodiscard]] Pose lost_before(const ChassisData& movement) const;

  Pose pose_;
  std::optional<ChassisData> newest_{};
};

// The pose at `time`, between two data sets or on their straight extension. The uncertainty is the
// larger one of both.
OdometryData interpolated(const OdometryData& before, const OdometryData& after, TimeStamp time);
PositionData interpolated(const PositionData& before, const PositionData& after, TimeStamp time);

// --- In the world
//
// Odometry is accurate for movements but not for poses: its frame drifts. The tracker stores the
// pose of that frame in the world: a known pose, and the pose of the odometry at the same moment.
// The position is the known pose plus the movement since, transformed to the world. The standard
// deviation grows with each millimetre and each radian. A new known pose moves the frame; to avoid
// a jump for controllers that use the position, it changes linearly from the old frame to the new
// one during the blending time.

// The growth of the standard deviation.
struct Drift {
  double x = 50;  // mm per metre along x
  double y = 50;  // mm per metre along y; for a metre across, a fifth
};

class PositionTracker {
 public:
  // mm, of a position that is not known yet: the first good fix counts whole.
  static constexpr int kUnknown = 100000;

  PositionTracker(const Drift& drift, std::chrono::milliseconds blending)
      : drift_(drift), blending_(blending) {}

  // The standard deviation at the origin, mm; that of the heading is 0.03 deg per mm. Without
  // effect once the position was updated.
  void expect(double deviation);

  // Starts with this odometry at the origin of the world; when started again, at the last position,
  // independent of the movement of the odometry in between.
  void begin(const Drift& drift, std::chrono::milliseconds blending, const OdometryData& odometry);

  // The current position. Without begin() the origin of the world is that of the odometry.
  PositionData follow(const OdometryData& odometry);

  // The position was `known` when the odometry was `then`. With blending, follow() approaches it
  // gradually.
  void update(const PositionData& known, const OdometryData& then);

 private:
  // The pose of the odometry's frame in the world.
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
  Frame earlier_;  // the previous frame, while blending
  bool blends_ = false;
  TimeStamp updated_ = 0;
  bool followed_ = false;
  OdometryData newest_{};
  Pose reported_{};               // by the last follow()
  Position3d known_deviation_{};  // z, phi and psi are not updated by odometry
  Deviation deviation_;
  bool is_updated_ = false;
};

}  // namespace rack::navigation
