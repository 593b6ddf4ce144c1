// What all satellite receivers have in common, whatever they speak.
#pragma once

#include <optional>

#include "components/devices/core/dialogue.h"
#include "rack/proxies/gps.h"
#include "rack/proxies/position.h"

namespace rack::device {

// When a receiver measured, by the clock of its satellites.
struct GpsMoment {
  std::optional<Duration> utc{};  // since 1970; none: it does not know the date yet
  bool is_leap_second = false;    // 23:59:60, which counts as the first second of the next day

  [[nodiscard]] Duration fraction() const;  // of the second
};

// Standard deviations where the receiver itself says nothing: the more satellites, the better.
struct GpsDeviations {
  i32 xy_max = 50000;  // mm, with 4 satellites, the fewest that give a height
  i32 xy_min = 10000;  // with 12 and more
  i32 z_max = 100000;
  i32 z_min = 20000;
  f32 rho = 0.349F;  // rad
};
Position3d guessed_deviations(const GpsDeviations& deviations, i32 mode, i32 satellites);

// When a fix was measured whose message arrived then, both by the clock that also saw the pulse of
// a second: the message says which fraction of a second it is of. None: the pulse is no longer one
// of these seconds.
std::optional<Duration> measured_by_pulse(Duration pulse, Duration fraction, Duration arrived);

// Where it is, by what was known and by a fix of that moment, each weighed by its deviation: the
// update of a Kalman filter whose measurement is the state. `has_course`: the fix has a heading,
// too. None: fixes of some minutes share most of their error, so what is known twice as well as one
// fix is not made better by it.
std::optional<PositionData> weighed(const PositionData& known, const GpsData& fix, bool has_course);

// 0 to 2 pi.
f32 heading_of(double degrees);

}  // namespace rack::device
