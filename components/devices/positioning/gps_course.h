// Default scene of an emulated satellite receiver: a circle at constant speed, at most 10 m above
// the initial altitude. The first fix takes some seconds, and the fix is lost periodically.
#pragma once

#include <cmath>
#include <numbers>

#include "components/devices/core/scene.h"

namespace rack::device::emulator {

struct GpsCourse {
  double latitude = 52.382;  // centre of the circle, deg
  double longitude = 9.717;
  double altitude = 60;                              // m
  double radius = 50;                                // m
  double speed = 2;                                  // m/s
  Duration begins = std::chrono::hours(24) * 20454;  // 2026-01-01
  Duration first_fix = std::chrono::seconds(4);
  Duration lost_every = std::chrono::seconds(60);  // period of losing the fix; 0: never
  Duration lost_for = std::chrono::seconds(5);

  [[nodiscard]] CoursePoint at(Duration since_start) const {
    constexpr double kMetersOfDegree = 111195;
    const double seconds = std::chrono::duration<double>(since_start).count();
    const double angle = speed * seconds / radius;  // clockwise from north
    const double degree = std::numbers::pi / 180;
    const bool is_lost =
        lost_every.count() > 0 && since_start % lost_every >= lost_every - lost_for;
    CoursePoint point;
    point.utc = begins + since_start;
    point.is_fixed = since_start >= first_fix && !is_lost;
    point.latitude = latitude + radius * std::cos(angle) / kMetersOfDegree;
    point.longitude =
        longitude + radius * std::sin(angle) / (kMetersOfDegree * std::cos(latitude * degree));
    point.altitude = altitude + 10 * std::sin(angle);
    point.course = std::fmod(angle / degree + 90, 360);
    point.speed = speed;
    point.satellites = point.is_fixed ? 8 + static_cast<int>(seconds) % 5 : 2;
    return point;
  }
  // For use as a Course.
  CoursePoint operator()(Time /*when*/, Duration since_start) const { return at(since_start); }
};

}  // namespace rack::device::emulator
