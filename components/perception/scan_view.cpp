#include "components/perception/scan_view.h"

#include <algorithm>
#include <cmath>

namespace rack::perception {
namespace {

constexpr std::size_t kScanViewPointsMax = decltype(Scan2dData::points)::kMax;
constexpr double kScanViewNearest = 50;  // mm: anything nearer is the scanner itself
constexpr double kFinest = radians(0.05);
constexpr double kCoarsest = radians(3);

}  // namespace

ScanView::ScanView() {
  beams_.reserve(kScanViewPointsMax);
  sights_.reserve(kScanViewPointsMax);
}

void ScanView::take(const Scan2dData& scan, const Pose& scanner, double range_max) {
  beams_.clear();
  sights_.clear();
  mounting_ = scanner;
  for (const ScanPoint& point : scan.points) {
    const bool nothing = (point.type & scan_point::kMaxRange) != 0;
    if ((point.type & scan_point::kInvalid) != 0 && !nothing) continue;
    const double dx = point.x - scanner.x;
    const double dy = point.y - scanner.y;
    const double away = std::hypot(dx, dy);
    if (away < kScanViewNearest) continue;
    const bool far = away > range_max;
    const double part = far ? range_max / away : 1;
    beams_.push_back({.angle = std::atan2(dy, dx),
                      .sight = {.local_x = static_cast<float>(scanner.x + dx * part),
                                .local_y = static_cast<float>(scanner.y + dy * part),
                                .away = away * part,
                                .hit = !nothing && !far}});
  }
  if (!std::ranges::is_sorted(beams_, {}, &Beam::angle))
    std::ranges::sort(beams_, {}, &Beam::angle);
  for (const Beam& beam : beams_) sights_.push_back(beam.sight);
  // Invalid beams are missing, so the median of the gaps would be the exact resolution, but it
  // costs a sort. The span divided by the number of points of the message is accurate enough.
  const double span = beams_.empty() ? 0 : beams_.back().angle - beams_.front().angle;
  const auto gaps = static_cast<double>(std::max<std::size_t>(scan.points.size(), 2) - 1);
  resolution_ = std::clamp(span / gaps, kFinest, kCoarsest);
  full_turn_ = span > 2 * kPi - 4 * resolution_;
  place({});
}

void ScanView::place(const Pose& robot) {
  scanner_ = robot + mounting_;
  const double c = std::cos(robot.rho);
  const double s = std::sin(robot.rho);
  for (Sight& sight : sights_) {
    const auto x = static_cast<double>(sight.local_x);
    const auto y = static_cast<double>(sight.local_y);
    sight.x = robot.x + x * c - y * s;
    sight.y = robot.y + x * s + y * c;
  }
}

}  // namespace rack::perception
