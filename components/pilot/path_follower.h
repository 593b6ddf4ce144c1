// Follows a path of splines. Pure.
//
// Control law: omega = v curvature + B (heading error + A lateral error). The first term follows
// the curvature of the path, the second corrects errors: the lateral error times A is the angle of
// approach to the path, and B is the rate at which that heading is reached. The error decays like a
// spring-damper system. The stiffness grows with the speed and the damping does not, so A is
// reduced with the speed to keep the motion well damped. The angle is also limited so that the
// lateral speed never exceeds pilotVTransMax. Commands take effect after a lag, so the controller
// uses the pose predicted from the commands that have not taken effect yet. (The original's
// follower was not published; this law matches the units of its parameters.)
//
// The speed is that of the path's profile at the predicted position. It grows no faster than the
// vehicle accelerates, and never exceeds the limit given by the caller. While the vehicle cannot
// brake as hard as commanded, steering uses the actual speed. At changes between forward and
// backward and in corners the vehicle stops; vehicles that can turn at rest do so there.
#pragma once

#include <array>
#include <chrono>
#include <span>
#include <vector>

#include "components/geometry/pose.h"
#include "components/path/polar_spline.h"
#include "rack/proxies/chassis.h"

namespace rack::pilot {

struct FollowerSettings {
  ChassisParamData chassis{};
  double speed_max = 0;  // mm/s, of the pilot; the chassis may have a lower one
  std::chrono::milliseconds period{50};
  std::chrono::milliseconds lag{100};  // from a command to the reaction of the wheels
  double steering_rate = 0;            // rad/s, of steered wheels; 0: no limit
};

inline double seconds(std::chrono::milliseconds time) {
  return std::chrono::duration<double>(time).count();
}

class PathFollower {
 public:
  enum class State : std::uint8_t {
    kNoPath,
    kRunning,
    kArrived,
    kAstray,  // too far from the path
  };
  struct Command {
    double speed = 0;  // mm/s, negative backward
    double omega = 0;  // rad/s
  };

  explicit PathFollower(const FollowerSettings& settings);

  // Joins a path at its nearest point. Allocates nothing for up to kSplinesMax splines.
  void take(std::span<const PolarSpline> path, const Pose& at);
  void drop();  // removes the path; the vehicle stops

  // Called once per period. `speed`: of the vehicle, mm/s; `speed_safe`: limit, mm/s.
  Command follow(const Pose& at, double speed, double speed_safe);

  // Stops and keeps the path.
  void hold(bool holds) { holds_ = holds; }
  [[nodiscard]] bool holds() const { return holds_; }
  // Drives back along the path for that time.
  void revert(std::chrono::milliseconds time) { revert_left_ = time; }
  [[nodiscard]] bool reverts() const { return revert_left_.count() > 0; }

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] std::span<const PolarSpline> path() const { return path_; }
  [[nodiscard]] std::size_t index() const { return index_; }   // of the current spline
  [[nodiscard]] double distance() const { return distance_; }  // on that spline, mm
  [[nodiscard]] double rest() const;                           // to the end of the path, mm
  [[nodiscard]] const path::Beside& beside() const { return beside_; }
  [[nodiscard]] Command last() const { return commands_[newest_]; }

 private:
  [[nodiscard]] Pose predicted(const Pose& at) const;
  void find_place(const Pose& at);
  void go_on(const Pose& at);
  [[nodiscard]] bool stops_ahead() const;
  [[nodiscard]] double ahead() const;
  [[nodiscard]] double profile(double further) const;
  [[nodiscard]] double curvature_at(double speed) const;
  [[nodiscard]] double steering_time(double from, double to) const;
  Command drive(double speed_now, double speed_safe);
  [[nodiscard]] Command braking(double speed_now, double sense) const;
  Command turn_at_rest(double missing) const;
  [[nodiscard]] double steer(double speed) const;
  [[nodiscard]] bool leave_stop(double speed);
  [[nodiscard]] bool is_astray() const;
  Command give(const Command& command);

  FollowerSettings settings_;
  std::vector<PolarSpline> path_;
  std::vector<double> rest_;  // after each spline, mm
  State state_ = State::kNoPath;
  std::size_t index_ = 0;
  double distance_ = 0;
  path::Beside beside_;
  bool turning_ = false;  // at rest
  bool holds_ = false;
  std::chrono::milliseconds revert_left_{0};

  static constexpr std::size_t kCommandsMax = 64;
  std::array<Command, kCommandsMax> commands_{};  // a ring of the last ones
  std::size_t newest_ = 0;
};

}  // namespace rack::pilot
