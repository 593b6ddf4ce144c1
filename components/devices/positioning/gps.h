// Common part of all satellite receivers, independent of their protocol.
#pragma once

#include <optional>

#include "components/devices/core/dialogue.h"
#include "rack/proxies/gps.h"
#include "rack/proxies/position.h"

namespace rack::device {

// Time of a measurement, according to the satellites.
struct GpsMoment {
  std::optional<Duration> utc{};  // since 1970; empty until the date is known
  bool is_leap_second = false;    // 23:59:60, represented as the first second of the next day

  [[nodiscard]] Duration fraction() const;  // fraction of the second
};

// Standard deviations if the receiver reports none, by the number of satellites.
struct GpsDeviations {
  i32 xy_max = 50000;  // mm, with 4 satellites, the minimum for a 3D fix
  i32 xy_min = 10000;  // mm, with 12 and more
  i32 z_max = 100000;
  i32 z_min = 20000;
  f32 rho = 0.349F;  // rad
};
Position3d guessed_deviations(const GpsDeviations& deviations, i32 mode, i32 satellites);

// The time of measurement of a fix from the last pulse per second, the fraction of the second in
// its message, and the arrival of the message; all by the same clock. Empty if the pulse is too
// old.
std::optional<Duration> measured_by_pulse(Duration pulse, Duration fraction, Duration arrived);

// Combines the known position and a fix of the same time, weighted by their variances: the update
// of a Kalman filter that measures its state. `has_course`: the fix has a heading. Empty if the
// known deviation is less than half of that of the fix: the errors of fixes within minutes are
// correlated, so another fix would not improve the position. A position that is not known yet (a
// deviation of 50 m and more; a heading of 90 degrees and more) becomes that of the fix.
std::optional<PositionData> weighed(const PositionData& known, const GpsData& fix, bool has_course);

// 0 to 2 pi.
f32 heading_of(double degrees);

}  // namespace rack::device
