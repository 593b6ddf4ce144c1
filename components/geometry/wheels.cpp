#include "components/geometry/wheels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace rack::device {
namespace {

constexpr double kStands = 1e-3;  // mm/s

// Solves a * x = b; a direction that no wheel determines has speed 0.
std::array<double, 3> solve(std::array<std::array<double, 4>, 3> rows) {
  constexpr double kNothing = 1e-9;
  std::array<double, 3> solution{};
  std::array<bool, 3> known{};
  for (std::size_t column = 0; column < 3; ++column) {
    std::size_t best = column;
    for (std::size_t row = column; row < 3; ++row)
      if (std::abs(rows[row][column]) > std::abs(rows[best][column])) best = row;
    std::swap(rows[column], rows[best]);
    known[column] = std::abs(rows[column][column]) > kNothing;
    if (!known[column]) continue;
    for (std::size_t row = 0; row < 3; ++row) {
      if (row == column) continue;
      const double factor = rows[row][column] / rows[column][column];
      for (std::size_t i = column; i < 4; ++i) rows[row][i] -= factor * rows[column][i];
    }
  }
  for (std::size_t i = 0; i < 3; ++i)
    if (known[i]) solution[i] = rows[i][3] / rows[i][i];
  return solution;
}

float within_range(float target, float smallest, float largest) {
  if (target == 0 || largest == 0) return 0;
  return std::copysign(std::min(std::max(std::abs(target), smallest), largest), target);
}

}  // namespace

ChassisSpeed within_limits(const ChassisMoveData& command, const ChassisParamData& limits) {
  const auto real = [](i32 speed) { return static_cast<float>(speed); };
  const float omega = std::isfinite(command.omega.raw()) ? command.omega.raw() : 0;
  return {.vx = within_range(real(command.vx), real(limits.vxMin), real(limits.vxMax)),
          .vy = within_range(real(command.vy), real(limits.vyMin), real(limits.vyMax)),
          .omega = within_range(omega, 0, limits.omegaMax)};
}

Wheels Wheels::differential(double track) {
  return {{{.x = 0, .y = -track / 2, .drive = 0}, {.x = 0, .y = track / 2, .drive = 1}}, 2, 0};
}

Wheels Wheels::ackermann(double base, double track, bool one_motor, double steer_max) {
  if (one_motor)
    return {{{.x = 0, .y = 0, .drive = 0}, {.x = base, .y = 0, .steer = 1}}, 2, steer_max};
  return {{{.x = 0, .y = -track / 2, .drive = 0},
           {.x = 0, .y = track / 2, .drive = 1},
           {.x = base, .y = 0, .steer = 2}},
          3,
          steer_max};
}

Wheels Wheels::double_ackermann(double base, double track, double steer_max) {
  constexpr int kFront = 4;
  constexpr int kRear = 5;
  const double half = base / 2;
  return {{{.x = half, .y = -track / 2, .drive = 0, .steer = kFront},
           {.x = half, .y = track / 2, .drive = 1, .steer = kFront},
           {.x = -half, .y = -track / 2, .drive = 2, .steer = kRear},
           {.x = -half, .y = track / 2, .drive = 3, .steer = kRear}},
          6,
          steer_max};
}

bool Wheels::is_steering(std::size_t motor) const {
  return std::ranges::any_of(
      wheels_, [&](const Wheel& wheel) { return wheel.steer == static_cast<int>(motor); });
}

void Wheels::targets(const ChassisSpeed& speed, std::span<double> motors) const {
  const double omega = static_cast<double>(speed.omega);
  const auto vx = static_cast<double>(speed.vx);
  const auto vy = static_cast<double>(speed.vy);
  // The steering angle is that of the axle's centre: both wheels of an axle have one motor.
  for (const Wheel& wheel : wheels_) {
    const double side = vy + omega * wheel.x;
    if (wheel.steer < 0 || std::hypot(vx, side) < kStands) continue;
    double angle = std::atan2(side, vx);
    if (angle > std::numbers::pi / 2) angle -= std::numbers::pi;  // backwards
    if (angle < -std::numbers::pi / 2) angle += std::numbers::pi;
    motors[static_cast<std::size_t>(wheel.steer)] = std::clamp(angle, -steer_max_, steer_max_);
  }
  for (const Wheel& wheel : wheels_) {
    if (wheel.drive < 0) continue;
    const double angle = wheel.steer < 0 ? 0 : motors[static_cast<std::size_t>(wheel.steer)];
    motors[static_cast<std::size_t>(wheel.drive)] =
        std::cos(angle) * (vx - omega * wheel.y) + std::sin(angle) * (vy + omega * wheel.x);
  }
}

ChassisSpeed Wheels::movement(std::span<const double> motors) const {
  std::array<std::array<double, 4>, 3> normal{};
  const auto add = [&](const std::array<double, 3>& row, double value) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) normal[i][k] += row[i] * row[k];
      normal[i][3] += row[i] * value;
    }
  };
  for (const Wheel& wheel : wheels_) {
    const double angle = wheel.steer < 0 ? 0 : motors[static_cast<std::size_t>(wheel.steer)];
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    if (wheel.drive >= 0)
      add({c, s, s * wheel.x - c * wheel.y}, motors[static_cast<std::size_t>(wheel.drive)]);
    // No wheel slips sideways; for an axle with a common steering angle, its centre does not.
    const double y = wheel.steer < 0 ? wheel.y : 0;
    add({-s, c, c * wheel.x + s * y}, 0);
  }
  const auto best = solve(normal);
  return {.vx = static_cast<float>(best[0]),
          .vy = static_cast<float>(best[1]),
          .omega = static_cast<float>(best[2])};
}

}  // namespace rack::device
