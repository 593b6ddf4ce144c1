// Common part of rotating range finders that send single points.
#pragma once

#include <cmath>
#include <numbers>

#include "rack/devices/dialogue.h"
#include "rack/proxies/ladar.h"

namespace rack::device {

// Normalises an angle to -pi up to pi; for angles at most some turns away.
template <typename Number>
constexpr Number within_turn(Number angle) {
  constexpr Number kHalf = std::numbers::pi_v<Number>;
  while (angle >= kHalf) angle -= 2 * kHalf;
  while (angle < -kHalf) angle += 2 * kHalf;
  return angle;
}

// Assembles points to scans of one turn, clockwise from behind over left, ahead and right. The
// first, incomplete turn is discarded. If a turn has more points than a scan can hold, every second
// point is kept, or every third, and so on.
class TurningScan {
 public:
  TurningScan();

  void set_range(i32 min, i32 max);  // mm; points outside are invalid
  void clear();
  // Adds consecutive points, of which the first was measured at `first`. Angles are clockwise from
  // straight ahead, rad, at most some turns away; 0 mm: no echo. Overwrites angles and types.
  void add(std::span<LadarPoint> points, Time first, Duration step);
  void add(double angle, i32 distance, i32 intensity, Time measured) {
    LadarPoint point{
        .angle = static_cast<f32>(angle), .distance = distance, .intensity = intensity};
    add({&point, 1}, measured, {});
  }
  bool take(LadarData& scan, Time& recorded);

  // Number of turns returned since clear().
  [[nodiscard]] std::uint64_t turns() const { return turns_; }

 private:
  static constexpr std::size_t kPointsMax = decltype(LadarData::points)::kMax;

  // Returns the number of points that belong to this turn; normalises their angles and sets their
  // types.
  std::size_t until_seam(std::span<LadarPoint> points);
  void keep(std::span<const LadarPoint> points);
  void end_turn(Time now);

  i32 range_min_ = 1;
  i32 range_max_ = 12'000;
  LadarData now_{};
  LadarData done_{};
  bool has_done_ = false;
  Time recorded_{};
  Time began_{};
  bool is_whole_ = false;   // this turn was received from its start and fits into a scan
  bool was_ahead_ = false;  // the turn has passed straight ahead: only then can it end
  bool was_right_ = false;  // the previous point was on the right
  std::size_t points_ = 0;  // number of points of this turn, including those not kept
  std::size_t keep_each_ = 1;
  std::size_t left_out_ = 0;  // points to skip before the next one is kept
  std::uint64_t turns_ = 0;
};

class TurningLadar : public Dialogue {
 public:
  // True after the first complete turn; from then on, further turns are expected.
  [[nodiscard]] bool is_ready() const { return scan_.turns() > 0; }
  bool take(LadarData& scan, Time& recorded) { return scan_.take(scan, recorded); }
  // Empty if the scanner does not report it.
  [[nodiscard]] virtual std::string serial_number() const { return {}; }

 protected:
  TurningScan scan_;
};

}  // namespace rack::device
