#include "components/devices/scanners/turning_ladar.h"

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
  left_out_ = 0;
  turns_ = 0;
}

void TurningScan::add(std::span<LadarPoint> points, Time first, Duration step) {
  for (;;) {
    const std::size_t count = until_seam(points);
    keep(points.first(count));
    if (count == points.size()) return;
    points = points.subspan(count);
    first += step * static_cast<std::int64_t>(count);
    end_turn(first);
  }
}

std::size_t TurningScan::until_seam(std::span<LadarPoint> points) {
  constexpr f32 kQuarter = std::numbers::pi_v<f32> / 2;
  bool was_ahead = was_ahead_;
  bool was_right = was_right_;
  std::size_t count = 0;
  for (; count < points.size(); ++count) {
    LadarPoint& point = points[count];
    const f32 angle = within_turn(point.angle.raw());
    const bool is_seen = point.distance >= range_min_ && point.distance <= range_max_;
    point.angle = angle;
    point.type = is_seen ? ladar_point::kUnknown : ladar_point::kInvalid;
    if (angle < -kQuarter && was_right && was_ahead) break;
    was_ahead = was_ahead || std::abs(angle) < kQuarter;
    was_right = angle > kQuarter;
  }
  was_ahead_ = was_ahead;
  was_right_ = was_right;
  return count;
}

void TurningScan::keep(std::span<const LadarPoint> points) {
  points_ += points.size();
  auto& kept = now_.points;
  if (keep_each_ == 1 && kept.size() + points.size() <= kPointsMax) {
    kept.insert(kept.end(), points.begin(), points.end());
    return;
  }
  std::size_t at = left_out_;
  for (; at < points.size(); at += keep_each_) {
    if (kept.size() == kPointsMax) {
      is_whole_ = false;  // the next turn keeps fewer points
      return;
    }
    kept.push_back(points[at]);
  }
  left_out_ = at - points.size();
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
  left_out_ = 0;
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
