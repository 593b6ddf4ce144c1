#include "components/devices/chassis/chassis_control.h"

#include <algorithm>
#include <cmath>

#include "components/geometry/motors.h"

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr Duration kStep = 20ms;  // time step while the speed changes

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
  wanted_ = within_limits(target, limits_);
  if (rules_.turns_on_the_spot || limits_.minTurningRadius <= 0) return;
  const float most = std::abs(wanted_.vx) / static_cast<float>(limits_.minTurningRadius.raw());
  wanted_.omega = std::clamp(wanted_.omega, -most, most);
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
  const Acceleration<float> limit = acceleration_of(limits_);
  now_.vx = limit.changed(now_.vx, wanted_.vx, seconds);
  now_.vy = limit.changed(now_.vy, wanted_.vy, seconds);
  if (rules_.turns_on_the_spot) {
    // The change of the turning speed is limited by that of the wheels.
    const float arm = std::max(static_cast<float>(limits_.trackWidth.raw()) / 2, 1.0F);
    const Acceleration<float> turning{limit.faster / arm, limit.slower / arm};
    now_.omega = turning.changed(now_.omega, wanted_.omega, seconds);
  } else {
    // The curvature is kept while the speed changes, because the steering determines it.
    now_.omega = wanted_.vx == 0 ? 0 : wanted_.omega / wanted_.vx * now_.vx;
  }
  return now_;
}

Time ChassisControl::next_change() const {
  const Time overdue = deadline_.due();
  return !deadline_.holds() || now_ == wanted_ ? overdue : std::min(stepped_ + kStep, overdue);
}

bool ChassisControl::take_overdue() { return std::exchange(overdue_, false); }

}  // namespace rack::device
