// Sends the motion of the vehicle to an Ibeo Lux (or its computer) over CAN, so that it can
// distinguish moving from static objects.
//
// Four frames of three bytes, 02 and a 16 bit big-endian number: 303 speed in cm/s, 304 lateral
// acceleration to the left in mm/s2, 305 steering angle to the left in 1/1000 rad, 306 yaw rate to
// the left in 1/10000 rad/s.
//
// Source: RACK 0.6.1, which computed the acceleration as v / omega and the steering angle with the
// track width; here they are v * omega and computed with the wheel base.
#pragma once

#include <array>

#include "rack/devices/dialogue.h"

namespace rack::device {

struct Motion {
  double speed = 0;  // mm/s
  double omega = 0;  // rad/s, clockwise
};

inline constexpr std::size_t kEgoFrames = 4;
inline constexpr std::uint32_t kFirstEgoId = 0x303;

using EgoFrame = std::array<std::byte, 3>;
// `wheel_base`: mm.
std::array<EgoFrame, kEgoFrames> ego_frames(const Motion& motion, double wheel_base);

class EgoMotion final : public Dialogue {
 public:
  explicit EgoMotion(double wheel_base) : wheel_base_(wheel_base) {}

  void start(Time, Output&) override { clear_failure(); }
  void on_arrival(const Arrival&, Output&) override {}
  [[nodiscard]] std::vector<CanFilter> wanted_frames() const override { return {}; }
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return has_update_ ? Time{} : tims::kNever; }

  // Sends the motion at once.
  void set_motion(const Motion& motion) {
    motion_ = motion;
    has_update_ = true;
  }

 private:
  double wheel_base_;
  Motion motion_;
  bool has_update_ = false;
};

}  // namespace rack::device
