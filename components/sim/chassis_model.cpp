#include "components/sim/chassis_model.h"

#include <algorithm>
#include <cmath>

namespace rack::sim {
namespace {

float limited(float wish, float smallest, float largest) {
  if (wish == 0) return 0;
  return std::copysign(std::min(std::max(std::abs(wish), smallest), largest), wish);
}

}  // namespace

ChassisModel::ChassisModel(const ChassisParamData& limits, bool acceleration)
    : limits_(limits), acceleration_(acceleration) {}

void ChassisModel::set_active_pilot(tims::Address pilot) {
  pilot_ = pilot;
  wanted_ = {};
}

void ChassisModel::move(const ChassisMoveData& wish) {
  const auto mm_per_s = [](i32 speed) { return static_cast<float>(speed); };
  wanted_.vx = limited(mm_per_s(wish.vx), mm_per_s(limits_.vxMin), mm_per_s(limits_.vxMax));
  wanted_.vy = limited(mm_per_s(wish.vy), mm_per_s(limits_.vyMin), mm_per_s(limits_.vyMax));
  const float omega = std::isfinite(wish.omega.raw()) ? wish.omega.raw() : 0;
  wanted_.omega = limited(omega, 0, limits_.omegaMax);
}

ChassisData ChassisModel::step(TimeStamp now, std::chrono::milliseconds period) {
  const float seconds = std::chrono::duration<float>(period).count();
  if (acceleration_) {
    now_.vx = approach(now_.vx, wanted_.vx, seconds);
    now_.vy = approach(now_.vy, wanted_.vy, seconds);
    now_.omega = wanted_.omega;
  } else {
    now_ = wanted_;
  }
  ChassisData data;
  data.recordingTime = now;
  data.deltaX = now_.vx * seconds;
  data.deltaY = now_.vy * seconds;
  data.deltaRho = now_.omega * seconds;
  data.vx = now_.vx;
  data.vy = now_.vy;
  data.omega = now_.omega;
  data.activePilot = pilot_;
  return data;
}

// Towards `to`, slower when it means braking.
float ChassisModel::approach(float from, float to, float seconds) const {
  const bool braking = std::abs(to) < std::abs(from) || to * from < 0;
  const i32 rate = braking ? limits_.decMax : limits_.accMax;
  const float step = static_cast<float>(rate) * seconds;
  return from + std::clamp(to - from, -step, step);
}

}  // namespace rack::sim
