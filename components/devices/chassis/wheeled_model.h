// Model of an emulated robot with two wheels: speeds of the wheels and odometry.
#pragma once

#include <array>

#include "components/devices/core/scene.h"
#include "components/geometry/delay.h"
#include "components/geometry/motors.h"
#include "components/geometry/pose.h"
#include "components/geometry/wheels.h"

namespace rack::device {

class WheeledModel {
 public:
  WheeledModel(double track, double acceleration)
      : track_(track),
        wheels_(Wheels::differential(track)),
        acceleration_{acceleration, acceleration} {}

  // Sets the target speeds, mm/s.
  void set_targets(double left, double right) { targets_.set({left, right}); }
  void set_lag(tims::Duration lag) { targets_.set_lag(lag); }
  void step(tims::Time now) {
    targets_.step(now, [&](double seconds) {
      left_.run(targets_.in_effect()[0], acceleration_, seconds);
      right_.run(targets_.in_effect()[1], acceleration_, seconds);
      const ChassisSpeed speed = wheels_.movement(Targets{left(), right()});
      pose_ = moved(pose_, {.x = speed.vx * seconds, .rho = speed.omega * seconds});
    });
  }

  [[nodiscard]] double left() const { return left_.speed; }
  [[nodiscard]] double right() const { return right_.speed; }
  [[nodiscard]] double left_distance() const { return left_.position; }  // mm
  [[nodiscard]] double right_distance() const { return right_.position; }
  [[nodiscard]] double track() const { return track_; }
  [[nodiscard]] const Pose& pose() const { return pose_; }  // since the start, with full turns
  [[nodiscard]] bool stands() const { return left() == 0 && right() == 0; }
  [[nodiscard]] bool must_stop() const { return targets_.newest() == Targets{}; }

 private:
  using Targets = std::array<double, 2>;

  double track_;
  Wheels wheels_;
  Acceleration<double> acceleration_;
  LaggingCommand<Targets> targets_;
  MotorMotion left_;
  MotorMotion right_;
  Pose pose_;
};

// Base of emulated robots with this model.
class WheeledRobot : public Dialogue, public emulator::Wheelwork {
 public:
  [[nodiscard]] const WheeledModel& body() const { return body_; }

  [[nodiscard]] std::size_t motor_count() const override { return 2; }
  void turned(Time now, std::span<double> distances) override {
    body_.step(now);
    distances[0] = body_.left_distance();
    distances[1] = body_.right_distance();
  }
  void set_lag(tims::Duration lag) override { body_.set_lag(lag); }

 protected:
  explicit WheeledRobot(const WheeledModel& body) : body_(body) {}

  WheeledModel body_;
};

}  // namespace rack::device
