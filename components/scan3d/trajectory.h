// The trajectory of a value over time, from samples: the angle of an axis, the pose of a robot.
// Pure.
//
// Samples may arrive twice and in any order; the newest ones are kept, sorted by time. Between two
// samples the value is interpolated linearly. A value is known only between two samples: there is
// no extrapolation. A pause between samples that is too long, or a step that is physically
// impossible, is not interpolated. Clocks may be set: a sample far away in time from all others
// clears them.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <span>

#include "components/geometry/pose.h"

namespace rack::scan3d {

// --- types of values

inline double between(double a, double b, double part) { return a + (b - a) * part; }
using rack::between;

inline bool is_usable(double angle) { return std::isfinite(angle) && std::abs(angle) < 1e6; }
inline bool is_usable(const Pose& pose) {
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.z) &&
         std::isfinite(pose.phi) && std::isfinite(pose.psi) && std::isfinite(pose.rho);
}

// Whether a value can change from one to the other within `ms`; rounding and noise are not steps.
inline bool is_continuous(double from, double to, double /*ms*/) {
  return std::abs(to - from) < 0.5;
}
inline bool is_continuous(const Pose& from, const Pose& to, double ms) {
  constexpr double kSpeed = 30;        // mm per ms
  constexpr double kTurning = 0.0125;  // rad per ms: two turns per second
  return std::hypot(to.x - from.x, to.y - from.y, to.z - from.z) < 50 + kSpeed * ms &&
         std::abs(signed_angle(to.rho - from.rho)) < 0.05 + kTurning * ms;
}

template <typename Value>
class Trajectory {
 public:
  // False: the sample cannot be used.
  bool add(TimeStamp time, const Value& value) {
    if (!is_usable(value)) return false;
    if (size_ > 0 && std::chrono::abs(time - newest()) > kFarAway) size_ = 0;
    const auto kept = std::span(samples_).first(size_);
    const auto after = std::ranges::upper_bound(kept, time, {}, &Sample::time);
    if (after != kept.begin() && std::prev(after)->time == time) {
      std::prev(after)->value = value;
      return true;
    }
    auto place = static_cast<std::size_t>(after - kept.begin());
    if (size_ < samples_.size()) {
      std::shift_right(samples_.begin() + static_cast<std::ptrdiff_t>(place),
                       samples_.begin() + static_cast<std::ptrdiff_t>(++size_), 1);
    } else {
      if (place == 0) return false;  // older than all
      --place;
      std::shift_left(samples_.begin(), samples_.begin() + static_cast<std::ptrdiff_t>(place) + 1,
                      1);
    }
    samples_[place] = {time, value};
    return true;
  }

  [[nodiscard]] bool is_empty() const { return size_ == 0; }
  [[nodiscard]] TimeStamp newest() const {
    return samples_[size_ - 1].time;
  }  // requires !is_empty()
  void clear() { size_ = 0; }

  // The value `ms` after `time`, with fractions. None: it is not known.
  [[nodiscard]] std::optional<Value> at(TimeStamp time, double ms) const {
    const auto kept = std::span(samples_).first(size_);
    const auto is_before = [&](const Sample& sample) { return ms_between(time, sample) <= ms; };
    const auto after = std::ranges::partition_point(kept, is_before);
    if (after == kept.begin()) return {};
    const Sample& before = *std::prev(after);
    const double since = ms - ms_between(time, before);
    if (since <= 0) return before.value;
    if (after == kept.end()) return {};
    const double pause = ms_between(before.time, *after);
    if (pause > kPauseMax || !is_continuous(before.value, after->value, pause)) return {};
    return between(before.value, after->value, since / pause);
  }

 private:
  struct Sample {
    TimeStamp time = 0;
    Value value{};
  };
  static constexpr std::chrono::seconds kFarAway{10};
  static constexpr double kPauseMax = 500;  // ms

  static double ms_between(TimeStamp time, const Sample& sample) {
    return static_cast<double>((sample.time - time).count());
  }

  std::array<Sample, 256> samples_{};
  std::size_t size_ = 0;
};

}  // namespace rack::scan3d
