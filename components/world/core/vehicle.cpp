#include "components/world/core/vehicle.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace rack::world {

namespace {

constexpr double kVehicleSeconds = std::chrono::duration<double>(kStep).count();
constexpr double kMetre = 1000;

device::Wheels wheels_of(const RobotDescription& robot) {
  switch (robot.kind) {
    case DriveKind::kAckermann:
      return device::Wheels::ackermann(robot.base, robot.track, false, robot.steer_max);
    case DriveKind::kDoubleAckermann:
      return device::Wheels::double_ackermann(robot.base, robot.track, robot.steer_max);
    case DriveKind::kDifferential:
      break;
  }
  return device::Wheels::differential(robot.track);
}

}  // namespace

Vehicle::Vehicle(const RobotDescription& robot, std::uint64_t seed)
    : limits_(robot), wheels_(wheels_of(robot)), random_(seed) {}

const Vehicle::Targets& Vehicle::newest() const {
  return in_flight_.newest() ? in_flight_.newest()->command : targets_;
}

void Vehicle::drive(std::span<const double> motors, tims::Time due) {
  Targets targets = newest();
  for (std::size_t i = 0; i < std::min(motors.size(), wheels_.motors()); ++i)
    if (std::isfinite(motors[i])) targets[i] = motors[i];
  in_flight_.push(targets, due);
}

void Vehicle::drive(const device::ChassisSpeed& speed, tims::Time due) {
  if (!std::isfinite(speed.vx) || !std::isfinite(speed.vy) || !std::isfinite(speed.omega)) return;
  Targets targets = newest();
  wheels_.targets(speed, std::span(targets).first(wheels_.motors()));
  in_flight_.push(targets, due);
}

void Vehicle::stop() {
  in_flight_.forget();
  for (std::size_t i = 0; i < motors_.size(); ++i) {
    if (wheels_.is_steering(i)) continue;
    targets_[i] = 0;
    motors_[i].speed = 0;
  }
}

void Vehicle::follow(std::size_t motor) {
  const double target = targets_[motor];
  if (wheels_.is_steering(motor))
    return motors_[motor].go_to(std::clamp(target, -limits_.steer_max, limits_.steer_max),
                                limits_.steering_rate, kVehicleSeconds);
  const bool brakes_alike = limits_.deceleration == 0;
  motors_[motor].run(target,
                     {.faster = limits_.acceleration,
                      .slower = brakes_alike ? limits_.acceleration : limits_.deceleration},
                     kVehicleSeconds);
}

Movement Vehicle::step(tims::Time begin) {
  while (const auto due = in_flight_.take(begin)) targets_ = due->command;
  std::array<double, kMotorsMax> now{};
  for (std::size_t i = 0; i < wheels_.motors(); ++i) {
    follow(i);
    now[i] = wheels_.is_steering(i) ? motors_[i].position : motors_[i].speed;
  }
  const device::ChassisSpeed speed = wheels_.movement(std::span(now).first(wheels_.motors()));
  return on_ground({static_cast<double>(speed.vx) * kVehicleSeconds,
                    static_cast<double>(speed.vy) * kVehicleSeconds,
                    static_cast<double>(speed.omega) * kVehicleSeconds});
}

Movement Vehicle::on_ground(Movement movement) {
  const SlipDescription& slip = limits_.slip;
  const double distance = std::hypot(movement.x, movement.y);
  const double root = std::sqrt(distance / kMetre + std::abs(movement.rho) / 2);
  const auto noise = [&](double deviation) {
    return deviation * root * static_cast<double>(random_.normal());
  };
  const double along = noise(slip.distance_noise);
  const double turned = noise(slip.turn_noise);
  const double share = distance > 0 ? 1 - slip.distance + along / distance : 1;
  return {movement.x * share, movement.y * share, movement.rho * (1 - slip.turn) + turned};
}

}  // namespace rack::world
