#include "components/mapping/view.h"

#include <algorithm>
#include <cmath>

namespace rack::mapping {

namespace {

constexpr double kViewNearest = 300;     // mm
constexpr double kViewFarthest = 15000;  // mm: errors of the heading count too much beyond
constexpr double kViewMargin = 250;      // mm
constexpr double kViewMarginByRange = 0.03;

}  // namespace

View::View(std::span<const BeamEnd> scan, const Pose& scanner) : x_(scanner.x), y_(scanner.y) {
  for (const BeamEnd& end : scan) {
    const double dx = static_cast<double>(end.x) - x_;
    const double dy = static_cast<double>(end.y) - y_;
    const double part = heading(std::atan2(dy, dx)) / (2 * kPi);
    if (!std::isfinite(dx) || !std::isfinite(dy)) continue;
    float& nearest = nearest_[static_cast<std::size_t>(part * kBearings) % kBearings];
    const auto range = static_cast<float>(std::hypot(dx, dy));
    if (nearest == 0 || range < nearest) nearest = range;
  }
}

Seen View::judge(double x, double y) const {
  const double dx = x - x_;
  const double dy = y - y_;
  const double range = std::hypot(dx, dy);
  if (!(range >= kViewNearest && range <= kViewFarthest)) return Seen::kUnknown;
  const double part = heading(std::atan2(dy, dx)) / (2 * kPi);
  const std::size_t middle = static_cast<std::size_t>(part * kBearings) % kBearings;
  if (nearest_[middle] == 0) return Seen::kUnknown;
  const double margin = kViewMargin + kViewMarginByRange * range;
  double least = 1e9;
  // Neighbours: where a wall is seen at a small angle, ranges change much from beam to beam.
  for (const std::size_t i : {middle + kBearings - 1, middle, middle + 1}) {
    const auto there = static_cast<double>(nearest_[i % kBearings]);
    if (there == 0) continue;
    if (std::abs(there - range) <= margin) return Seen::kThere;
    least = std::min(least, there);
  }
  return range < least ? Seen::kThrough : Seen::kUnknown;
}

Agreement View::judge(std::span<const ScanPoint2d> points, const Pose& frame) const {
  const double c = std::cos(frame.rho);
  const double s = std::sin(frame.rho);
  Agreement agreement;
  for (const ScanPoint2d& p : points) {
    if (!p.on_wall()) continue;
    const auto px = static_cast<double>(p.x);
    const auto py = static_cast<double>(p.y);
    const Seen seen = judge(frame.x + c * px - s * py, frame.y + s * px + c * py);
    if (seen == Seen::kThere) ++agreement.seen;
    if (seen == Seen::kThrough) ++agreement.seen_through;
  }
  return agreement;
}

}  // namespace rack::mapping
