// Follows a path of splines. Pure.
//
// The law: omega = v curvature + B (heading error + A lateral error). The first part drives the
// path as it bends, the second brings the vehicle back to it: a lateral error, times A, is the
// angle at which it is approached, and B is how quickly that heading is taken. So the error dies
// out like that of a spring and a damper; since the spring grows with the speed and the damper does
// not, A is lowered with the speed until the motion is damped well. The angle is also bounded so
// that the vehicle never goes faster than pilotVTransMax to the side. What it decides takes effect
// only after a lag: so it steers by where it will be then, from the commands that are under way.
// (The original's follower was not published; its law is that of the units of its parameters.)
//
// The speed is that of the path's profile where it will be, grows no faster than the vehicle
// accelerates, and is never more than what whoever calls allows. While it brakes harder than the
// vehicle can, it steers for the speed that is left. Where the path changes between
// forward and backward, and in corners, it stops; one who turns at rest does so there.
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
  std::chrono::milliseconds lag{100};  // until the wheels begin to do what was commanded
  double steering_rate = 0;            // rad/s, of steered wheels; 0: they need no time
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

  // Goes on with a path at that place of it that is the nearest. Allocates nothing for up to
  // kSplinesMax splines.
  void take(std::span<const PolarSpline> path, const Pose& at);
  void drop();  // the path; it stops

  // Once a period. `speed`: of the vehicle, mm/s; `speed_safe`: what is allowed, mm/s.
  Command follow(const Pose& at, double speed, double speed_safe);

  // It stops, and stays on the path.
  void hold(bool holds) { holds_ = holds; }
  [[nodiscard]] bool holds() const { return holds_; }
  // Goes back where it came from along the path, for that time.
  void revert(std::chrono::milliseconds time) { revert_left_ = time; }
  [[nodiscard]] bool reverts() const { return revert_left_.count() > 0; }

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] std::span<const PolarSpline> path() const { return path_; }
  [[nodiscard]] std::size_t index() const { return index_; }  // of the spline it is on
  [[nodiscard]] double way() const { return way_; }           // on that spline, mm
  [[nodiscard]] double rest() const;                          // to the end of the path, mm
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
  double way_ = 0;
  path::Beside beside_;
  bool turning_ = false;  // at rest
  bool holds_ = false;
  std::chrono::milliseconds revert_left_{0};

  static constexpr std::size_t kCommandsMax = 64;
  std::array<Command, kCommandsMax> commands_{};  // a ring of the last ones
  std::size_t newest_ = 0;
};

}  // namespace rack::pilot
