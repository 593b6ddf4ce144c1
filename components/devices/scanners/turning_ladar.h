// Range finders that turn and turn, and send single points: what they have in common.
#pragma once

#include <cmath>
#include <numbers>

#include "components/devices/core/dialogue.h"
#include "rack/proxies/ladar.h"

namespace rack::device {

// To -pi up to pi; of angles that are some turns away at most.
template <typename Number>
constexpr Number within_turn(Number angle) {
  constexpr Number kHalf = std::numbers::pi_v<Number>;
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
  // One after the other, the first of them measured at `first`: their angles clockwise from ahead,
  // rad, some turns away at most; 0 mm: nothing was seen. Angles and types are written over.
  void add(std::span<LadarPoint> points, Time first, Duration step);
  void add(double angle, i32 distance, i32 intensity, Time measured) {
    LadarPoint point{
        .angle = static_cast<f32>(angle), .distance = distance, .intensity = intensity};
    add({&point, 1}, measured, {});
  }
  bool take(LadarData& scan, Time& recorded);

  // That were handed out, since clear().
  [[nodiscard]] std::uint64_t turns() const { return turns_; }

 private:
  static constexpr std::size_t kPointsMax = decltype(LadarData::points)::kMax;

  // How many of them belong to this turn. Brings their angles within it, says their types.
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
  bool is_whole_ = false;   // this turn was seen from its beginning, and fits
  bool was_ahead_ = false;  // it has come around: only then it can end
  bool was_right_ = false;  // the point before
  std::size_t points_ = 0;  // of this turn, also those that are not kept
  std::size_t keep_each_ = 1;
  std::size_t left_out_ = 0;  // points, before the next one is kept
  std::uint64_t turns_ = 0;
};

class TurningLadar : public Dialogue {
 public:
  // The first turn is whole: from now on the next ones are to be expected.
  [[nodiscard]] bool is_ready() const { return scan_.turns() > 0; }
  bool take(LadarData& scan, Time& recorded) { return scan_.take(scan, recorded); }
  // Empty: it tells none.
  [[nodiscard]] virtual std::string serial_number() const { return {}; }

 protected:
  TurningScan scan_;
};

}  // namespace rack::device
