// Range finders that turn and turn, and send single points: what they have in common.
#pragma once

#include <cmath>
#include <numbers>

#include "devices/core/dialogue.h"
#include "rack/proxies/ladar.h"

namespace rack::device {

// To -pi up to pi; of angles that are some turns away at most.
constexpr double within_turn(double angle) {
  constexpr double kHalf = std::numbers::pi;
  while (angle >= kHalf) angle -= 2 * kHalf;
  while (angle < -kHalf) angle += 2 * kHalf;
  return angle;
}

// Points become scans of one turn, from behind over left, ahead and right to behind. The first one
// that begins in the middle of a turn is left out. Where a turn has more points than a scan takes,
// each second one is kept, or each third, and so on.
class TurningScan {
 public:
  TurningScan();

  void set_range(i32 min, i32 max);  // mm; what lies outside is no point
  void clear();
  // Clockwise from ahead, rad, some turns away at most; 0 mm: nothing was seen.
  void add(double angle, i32 distance, i32 intensity, Time measured) {
    constexpr double kQuarter = std::numbers::pi / 2;
    const double within = within_turn(angle);
    if (within < -kQuarter && was_right_ && was_ahead_) end_turn(measured);
    was_ahead_ = was_ahead_ || std::abs(within) < kQuarter;
    was_right_ = within > kQuarter;
    ++points_;
    if (--until_kept_ == 0) keep(within, distance, intensity);
  }
  bool take(LadarData& scan, Time& recorded);

  // That were handed out, since clear().
  [[nodiscard]] std::uint64_t turns() const { return turns_; }

 private:
  static constexpr std::size_t kPointsMax = decltype(LadarData::points)::kMax;

  void end_turn(Time now);
  void keep(double angle, i32 distance, i32 intensity) {
    until_kept_ = keep_each_;
    if (now_.points.size() == kPointsMax) {
      is_whole_ = false;  // the next turn keeps fewer
      return;
    }
    const bool is_seen = distance >= range_min_ && distance <= range_max_;
    now_.points.push_back({.angle = static_cast<f32>(angle),
                           .distance = distance,
                           .type = is_seen ? ladar_point::kUnknown : ladar_point::kInvalid,
                           .intensity = intensity});
  }

  i32 range_min_ = 1;
  i32 range_max_ = 12'000;
  LadarData now_{};
  LadarData done_{};
  bool has_done_ = false;
  Time recorded_{};
  Time began_{};
  bool is_whole_ = false;   // this turn was seen from its beginning, and fits
  bool was_ahead_ = false;  // it has come around: only then it can end
  bool was_right_ = false;  // the point before
  std::size_t points_ = 0;  // of this turn, also those that are not kept
  std::size_t keep_each_ = 1;
  std::size_t until_kept_ = 1;
  std::uint64_t turns_ = 0;
};

class TurningLadar : public Dialogue {
 public:
  // The first turn is whole: from now on the next ones are to be expected.
  [[nodiscard]] bool is_ready() const { return scan_.turns() > 0; }
  bool take(LadarData& scan, Time& recorded) { return scan_.take(scan, recorded); }

 protected:
  TurningScan scan_;
};

}  // namespace rack::device
