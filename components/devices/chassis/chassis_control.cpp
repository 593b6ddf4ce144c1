#include "components/devices/chassis/chassis_control.h"

#include <algorithm>
#include <cmath>

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr Duration kStep = 20ms;  // time step while the speed changes

float limited(float target, i32 smallest, i32 largest) {
  if (target == 0 || largest == 0) return 0;
  const auto low = static_cast<float>(smallest);
  const auto high = static_cast<float>(largest);
  return std::copysign(std::min(std::max(std::abs(target), low), high), target);
}

}  // namespace

void ChassisControl::set_active_pilot(tims::Address pilot) {
  pilot_ = pilot;
  stop();
  deadline_.forget();
}

void ChassisControl::stop() {
  wanted_ = {};
  now_ = {};
  deadline_.end();
}

void ChassisControl::move(const ChassisMoveData& target, Time now) {
  if (!deadline_.holds()) stepped_ = now;
  deadline_.on_move(now);
  wanted_ = within_limits(target);
}

ChassisSpeed ChassisControl::within_limits(const ChassisMoveData& target) const {
  ChassisSpeed speed{
      .vx = limited(static_cast<float>(target.vx.raw()), limits_.vxMin, limits_.vxMax),
      .vy = limited(static_cast<float>(target.vy.raw()), limits_.vyMin, limits_.vyMax),
      .omega = std::isfinite(target.omega.raw()) ? target.omega.raw() : 0};
  float most = limits_.omegaMax.raw();
  if (!rules_.turns_on_the_spot && limits_.minTurningRadius > 0) {
    const float radius = static_cast<float>(limits_.minTurningRadius.raw());
    most = std::min(most, std::abs(speed.vx) / radius);
  }
  speed.omega = std::clamp(speed.omega, -most, most);
  return speed;
}

ChassisSpeed ChassisControl::speed(Time now) {
  if (!deadline_.holds()) return {};
  if (deadline_.due() <= now) {
    overdue_ = overdue_ || wanted_ != ChassisSpeed{} || now_ != ChassisSpeed{};
    stop();
    return {};
  }
  const float seconds = std::chrono::duration<float>(std::max(now - stepped_, Duration(0))).count();
  stepped_ = now;
  const auto faster = static_cast<float>(limits_.accMax.raw());
  const auto slower = static_cast<float>(limits_.decMax.raw());
  now_.vx = approach(now_.vx, wanted_.vx, faster, slower, seconds);
  now_.vy = approach(now_.vy, wanted_.vy, faster, slower, seconds);
  if (rules_.turns_on_the_spot) {
    // The change of the turning speed is limited by that of the wheels.
    const float arm = std::max(static_cast<float>(limits_.trackWidth.raw()) / 2, 1.0F);
    now_.omega = approach(now_.omega, wanted_.omega, faster / arm, slower / arm, seconds);
  } else {
    // The curvature is kept while the speed changes, because the steering determines it.
    now_.omega = wanted_.vx == 0 ? 0 : wanted_.omega / wanted_.vx * now_.vx;
  }
  return now_;
}

// Moves `from` towards `to`, with the deceleration when braking. An acceleration of 0 does not
// limit.
float ChassisControl::approach(float from, float to, float acceleration, float deceleration,
                               float seconds) const {
  const bool brakes = std::abs(to) < std::abs(from) || to * from < 0;
  const float rate = brakes ? deceleration : acceleration;
  if (rate <= 0) return to;
  return from + std::clamp(to - from, -rate * seconds, rate * seconds);
}

Time ChassisControl::next_change() const {
  const Time overdue = deadline_.due();
  return !deadline_.holds() || now_ == wanted_ ? overdue : std::min(stepped_ + kStep, overdue);
}

bool ChassisControl::take_overdue() { return std::exchange(overdue_, false); }

}  // namespace rack::device
