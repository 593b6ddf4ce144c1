// For tests: a car with steered front wheels that take time to turn, limited acceleration, a lag of
// commands, and noise of the position.
#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <random>

#include "components/geometry/motors.h"
#include "components/pilot/path_follower.h"

namespace rack::pilot {

struct CarModel {
  ChassisParamData chassis{};
  double steering_rate = 0.7;    // rad/s
  double lag = 0.1;              // s
  double position_noise = 15;    // mm, standard deviation
  double heading_noise = 0.004;  // rad
  bool turns_at_rest = false;    // differential drive
};

class Car {
 public:
  static constexpr double kStep = 0.005;  // s

  Car(const CarModel& model, const Pose& at, unsigned seed)
      : model_(model),
        at_(at),
        random_(seed),
        in_flight_(static_cast<std::size_t>(model.lag / kStep)) {}

  [[nodiscard]] const Pose& truth() const { return at_; }
  [[nodiscard]] double speed() const { return speed_; }
  Pose measured() {
    std::normal_distribution<double> noise;
    return {.x = at_.x + model_.position_noise * noise(random_),
            .y = at_.y + model_.position_noise * noise(random_),
            .rho = at_.rho + model_.heading_noise * noise(random_)};
  }
  // Sets the current speed; everything else is kept.
  void start_with(double speed) {
    speed_ = speed;
    for (auto& command : in_flight_) command = {speed, 0};
  }

  void step(const PathFollower::Command& command) {
    in_flight_.push_back(command);
    const PathFollower::Command now = in_flight_.front();
    in_flight_.pop_front();
    const ChassisParamData& c = model_.chassis;
    double wanted = std::clamp(now.speed, -1.0 * c.vxMax, 1.0 * c.vxMax);
    if (wanted != 0 && std::abs(wanted) < c.vxMin) wanted = std::copysign(c.vxMin, wanted);
    const device::Acceleration<double> limit{1.0 * c.accMax, 1.0 * c.decMax};
    speed_ = limit.changed(speed_, wanted, kStep);
    double turn = 0;
    if (model_.turns_at_rest) {
      turn = std::clamp<double>(now.omega, -c.omegaMax, c.omegaMax);
    } else {
      if (std::abs(now.speed) > 1) aim_ = std::atan(c.wheelBase * now.omega / now.speed);
      const double widest = std::atan(1.0 * c.wheelBase / std::max(1, c.minTurningRadius.raw()));
      steering_ = device::towards(steering_, std::clamp(aim_, -widest, widest),
                                  model_.steering_rate, kStep);
      turn = speed_ * std::tan(steering_) / c.wheelBase;
    }
    at_ = moved(at_, {.x = speed_ * kStep, .rho = turn * kStep});
  }

 private:
  CarModel model_;
  Pose at_;
  double speed_ = 0;
  double aim_ = 0;
  double steering_ = 0;
  std::mt19937 random_;
  std::deque<PathFollower::Command> in_flight_;
};

// Approximately the robot Dora.
inline ChassisParamData car_chassis() {
  ChassisParamData chassis;
  chassis.vxMax = 4000;
  chassis.vxMin = 50;
  chassis.accMax = 1500;
  chassis.decMax = 2000;
  chassis.omegaMax = 1;
  chassis.minTurningRadius = 3000;
  chassis.breakConstant = 1.4F;
  chassis.safetyMargin = 50;
  chassis.safetyMarginMove = 200;
  chassis.boundaryFront = 1700;
  chassis.boundaryBack = 600;
  chassis.boundaryLeft = chassis.boundaryRight = 600;
  chassis.wheelBase = 1200;
  chassis.pilotParameterA = 0.001F;
  chassis.pilotParameterB = 2;
  chassis.pilotVTransMax = 400;
  return chassis;
}

inline ChassisParamData indoor_chassis() {
  ChassisParamData chassis;
  chassis.vxMax = 1000;
  chassis.vxMin = 50;
  chassis.accMax = chassis.decMax = 700;
  chassis.omegaMax = 1;
  chassis.minTurningRadius = 0;
  chassis.breakConstant = 1;
  chassis.safetyMargin = 50;
  chassis.safetyMarginMove = 100;
  chassis.boundaryFront = chassis.boundaryBack = 250;
  chassis.boundaryLeft = chassis.boundaryRight = 250;
  chassis.wheelBase = 280;
  chassis.pilotParameterA = 0.001F;
  chassis.pilotParameterB = 2;
  chassis.pilotVTransMax = 200;
  return chassis;
}

}  // namespace rack::pilot
