#include "devices/protocol/turning_ladar.h"

#include <utility>

namespace rack::device {
TurningScan::TurningScan() {
  for (LadarData* const scan : {&now_, &done_}) {
    reserve_all(*scan);
    scan->startAngle = static_cast<f32>(-std::numbers::pi);
    scan->endAngle = static_cast<f32>(std::numbers::pi);
  }
}

void TurningScan::set_range(i32 min, i32 max) {
  range_min_ = min;
  range_max_ = max;
}

void TurningScan::clear() {
  now_.points.clear();
  has_done_ = is_whole_ = was_ahead_ = was_right_ = false;
  points_ = 0;
  until_kept_ = 1;
  turns_ = 0;
}

void TurningScan::end_turn(Time now) {
  using Milliseconds = std::chrono::milliseconds;
  if (is_whole_) {
    std::swap(now_, done_);
    done_.maxRange = range_max_;
    done_.startAngle = static_cast<f32>(-std::numbers::pi);
    done_.endAngle = static_cast<f32>(std::numbers::pi);
    done_.duration =
        static_cast<u32>(std::chrono::duration_cast<Milliseconds>(now - began_).count());
    recorded_ = began_ + (now - began_) / 2;
    has_done_ = true;
    ++turns_;
  }
  now_.points.clear();
  keep_each_ = points_ / kPointsMax + 1;
  until_kept_ = 1;
  points_ = 0;
  is_whole_ = true;
  was_ahead_ = was_right_ = false;
  began_ = now;
}

bool TurningScan::take(LadarData& scan, Time& recorded) {
  if (!std::exchange(has_done_, false)) return false;
  std::swap(scan, done_);
  recorded = recorded_;
  return true;
}

}  // namespace rack::device
