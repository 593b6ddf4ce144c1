// Model of an emulated robot with two wheels: speeds of the wheels and odometry.
#pragma once

#include <algorithm>
#include <cmath>

#include "components/devices/core/scene.h"
#include "components/geometry/delay.h"

namespace rack::device {

class WheeledModel {
 public:
  WheeledModel(double track, double acceleration) : track_(track), acceleration_(acceleration) {}

  // Sets the target speeds, mm/s.
  void want(double left, double right) {
    wanted_left_ = left;
    wanted_right_ = right;
    if (lag_ == tims::Duration{})
      does_ = {left, right};
    else
      under_way_.tell({left, right}, last_ + lag_);
  }
  void set_lag(tims::Duration lag) { lag_ = lag; }
  void step(tims::Time now) {
    // Arrivals have the time when they were on the line, which may be before the last step.
    if (last_ == tims::Time{}) last_ = now;
    if (now < last_) return;
    while (const auto due = under_way_.take(now)) {
      go_on(std::max(due->at, last_));
      does_ = due->command;
    }
    go_on(now);
  }

  [[nodiscard]] double left() const { return left_; }
  [[nodiscard]] double right() const { return right_; }
  [[nodiscard]] double left_way() const { return left_way_; }  // mm
  [[nodiscard]] double right_way() const { return right_way_; }
  [[nodiscard]] double track() const { return track_; }
  [[nodiscard]] double x() const { return x_; }  // mm; x forward, y to the right
  [[nodiscard]] double y() const { return y_; }
  [[nodiscard]] double heading() const { return heading_; }  // rad, clockwise
  [[nodiscard]] bool stands() const { return left_ == 0 && right_ == 0; }
  [[nodiscard]] bool is_told_to_stand() const { return wanted_left_ == 0 && wanted_right_ == 0; }

 private:
  struct Speeds {
    double left = 0;
    double right = 0;
  };

  void go_on(tims::Time now) {
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    const double change = acceleration_ * seconds;
    left_ += std::clamp(does_.left - left_, -change, change);
    right_ += std::clamp(does_.right - right_, -change, change);
    left_way_ += left_ * seconds;
    right_way_ += right_ * seconds;
    const double heading = heading_ + (left_ - right_) / track_ * seconds / 2;
    x_ += (left_ + right_) / 2 * seconds * std::cos(heading);
    y_ += (left_ + right_) / 2 * seconds * std::sin(heading);
    heading_ += (left_ - right_) / track_ * seconds;
  }

  double track_;
  double acceleration_;
  tims::Duration lag_{};
  Delay<Speeds> under_way_;
  Speeds does_{};  // target speeds in effect, after the delay
  double wanted_left_ = 0;
  double wanted_right_ = 0;
  double left_ = 0;
  double right_ = 0;
  double left_way_ = 0;
  double right_way_ = 0;
  double x_ = 0;
  double y_ = 0;
  double heading_ = 0;
  tims::Time last_{};
};

// Base of emulated robots with this model.
class WheeledRobot : public Dialogue, public emulator::Wheelwork {
 public:
  [[nodiscard]] const WheeledModel& body() const { return body_; }

  [[nodiscard]] std::size_t motor_count() const override { return 2; }
  void turned(Time now, std::span<double> ways) override {
    body_.step(now);
    ways[0] = body_.left_way();
    ways[1] = body_.right_way();
  }
  void set_lag(tims::Duration lag) override { body_.set_lag(lag); }

 protected:
  explicit WheeledRobot(const WheeledModel& body) : body_(body) {}

  WheeledModel body_;
};

}  // namespace rack::device
