#include "components/devices/scanners/ego_motion.h"

#include <algorithm>
#include <cmath>

namespace rack::device {
namespace {

constexpr std::byte kEgoMotionSize{2};

EgoFrame frame_of(double value) {
  constexpr double kLargest = 32767;
  const auto number =
      static_cast<unsigned>(static_cast<int>(std::lround(std::clamp(value, -kLargest, kLargest))));
  return {kEgoMotionSize, static_cast<std::byte>(number >> 8), static_cast<std::byte>(number)};
}

}  // namespace

std::array<EgoFrame, kEgoFrames> ego_frames(const Motion& motion, double wheel_base) {
  constexpr double kOfCentimetre = 10;
  constexpr double kStandsStill = 1;  // mm/s
  const double speed = std::abs(motion.speed);
  const double steering = speed < kStandsStill ? 0 : std::atan(wheel_base * motion.omega / speed);
  return {frame_of(motion.speed / kOfCentimetre), frame_of(-speed * motion.omega),
          frame_of(-1000 * steering), frame_of(-10'000 * motion.omega)};
}

void EgoMotion::on_timeout(Time, Output& out) {
  if (!has_update_) return;
  has_update_ = false;
  std::uint32_t id = kFirstEgoId;
  for (const EgoFrame& frame : ego_frames(motion_, wheel_base_)) out.send(frame, id++);
}

}  // namespace rack::device
