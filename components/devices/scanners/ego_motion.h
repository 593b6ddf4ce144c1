// How a vehicle moves, told to an Ibeo Lux (or its computer) over CAN, so that it can tell what
// moves from what is passed.
//
// Four frames of three bytes, 02 and a number of 16 bits, big-endian: 303 speed in cm/s, 304
// acceleration to the left in mm/s2, 305 angle of steering to the left in 1/1000 rad, 306 rate of
// turn to the left in 1/10000 rad/s.
//
// Source: what RACK 0.6.1 sends. Its acceleration was v divided by omega, its steering took the
// width of the track for the wheel base: here it is v times omega, and the wheel base.
#pragma once

#include <array>

#include "components/devices/core/dialogue.h"

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
  [[nodiscard]] Time next_timeout() const override { return has_news_ ? Time{} : tims::kNever; }

  // Is sent at once.
  void tell(const Motion& motion) {
    motion_ = motion;
    has_news_ = true;
  }

 private:
  double wheel_base_;
  Motion motion_;
  bool has_news_ = false;
};

}  // namespace rack::device
