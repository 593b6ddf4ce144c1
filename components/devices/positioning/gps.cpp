#include "components/devices/positioning/gps.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rack::device {

using namespace std::chrono_literals;

Duration GpsMoment::fraction() const { return utc ? *utc % Duration(1s) : Duration(0); }

Position3d guessed_deviations(const GpsDeviations& deviations, i32 mode, i32 satellites) {
  constexpr double kFewest = 4;
  constexpr double kEnough = 12;
  const double share = mode == gps_mode::kInvalid
                           ? 0
                           : std::clamp((satellites - kFewest) / (kEnough - kFewest), 0.0, 1.0);
  const auto between = [share](i32 max, i32 min) {
    return static_cast<i32>(std::lround(std::lerp(max, min, share)));
  };
  const i32 xy = between(deviations.xy_max, deviations.xy_min);
  return {
      .x = xy, .y = xy, .z = between(deviations.z_max, deviations.z_min), .rho = deviations.rho};
}

std::optional<Duration> measured_by_pulse(Duration pulse, Duration fraction, Duration arrived) {
  constexpr Duration kSecond = 1s;
  Duration measured = pulse + fraction;
  if (measured > arrived) measured -= kSecond;  // measured in the second before the pulse
  if (measured > arrived || arrived - measured >= kSecond) return std::nullopt;
  return measured;
}

std::optional<PositionData> weighed(const PositionData& known, const GpsData& fix,
                                    bool has_course) {
  // A Position that was never updated has a standard deviation of 100 m (startDeviation) around an
  // origin that may be a continent away: a weighted mean would not be at the fix.
  constexpr i32 kUnknown = 50000;                        // mm
  constexpr double kUnknownTurn = std::numbers::pi / 2;  // rad
  if (2.0 * std::max(known.var.x, known.var.y) <= std::max(fix.var.x, fix.var.y)) return {};
  // Weight of the fix: 0 keeps the known value, 1 takes that of the fix.
  const auto share = [](double known_deviation, double fix_deviation) {
    const double squares = known_deviation * known_deviation + fix_deviation * fix_deviation;
    return squares > 0 ? known_deviation * known_deviation / squares : 0;
  };
  const auto length = [&](auto& at, auto& deviation, const auto& fix_at,
                          const auto& fix_deviation) {
    if (deviation >= kUnknown) {
      at = fix_at;
      deviation = fix_deviation;
      return;
    }
    const double part = share(deviation, fix_deviation);
    at = static_cast<i32>(std::lround(at + part * (static_cast<double>(fix_at) - at)));
    deviation = static_cast<i32>(std::lround(deviation * std::sqrt(1 - part)));
  };
  PositionData both = known;
  both.recordingTime = fix.recordingTime;
  length(both.pos.x, both.var.x, fix.pos.x, fix.var.x);
  length(both.pos.y, both.var.y, fix.pos.y, fix.var.y);
  if (!has_course) return both;
  const double part = known.var.rho >= kUnknownTurn ? 1 : share(known.var.rho, fix.var.rho);
  const double turn = std::remainder(fix.pos.rho - known.pos.rho, 2 * std::numbers::pi);
  both.pos.rho = part == 1 ? fix.pos.rho.raw() : static_cast<f32>(known.pos.rho + part * turn);
  both.var.rho =
      part == 1 ? fix.var.rho.raw() : static_cast<f32>(known.var.rho * std::sqrt(1 - part));
  return both;
}

f32 heading_of(double degrees) {
  const double turn = std::fmod(degrees, 360.0);
  return static_cast<f32>((turn < 0 ? turn + 360 : turn) * std::numbers::pi / 180);
}

}  // namespace rack::device
