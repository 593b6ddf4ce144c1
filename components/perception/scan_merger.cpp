#include "components/perception/scan_merger.h"

#include <algorithm>
#include <cmath>

namespace rack::perception {

ScanMerger::ScanMerger() {
  for (Source& source : sources_) source.points.reserve(kPointsMax);
  seen_.reserve(kSourcesMax * kPointsMax);
}

bool ScanMerger::take(std::size_t source, const Scan2dData& scan, const Pose& odometry) {
  if (source >= kSourcesMax || !std::isfinite(odometry.x + odometry.y + odometry.rho)) return false;
  Source& into = sources_[source];
  if (into.known && scan.recordingTime - into.newest < std::chrono::milliseconds(0)) return false;
  const bool whole = scan.sectorNum <= 1;
  if (whole)
    into.points.clear();
  else
    std::erase_if(into.points, [&](const Point& p) { return p.sector == scan.sectorIndex; });
  const double c = std::cos(odometry.rho);
  const double s = std::sin(odometry.rho);
  for (const ScanPoint& point : scan.points) {
    if (into.points.size() == kPointsMax) break;
    const double x = point.x;
    const double y = point.y;
    into.points.push_back({.x = odometry.x + x * c - y * s,
                           .y = odometry.y + x * s + y * c,
                           .sector = whole ? 0 : scan.sectorIndex,
                           .type = point.type,
                           .intensity = point.intensity});
  }
  into.newest = scan.recordingTime;
  into.oldest = scan.recordingTime - std::chrono::milliseconds(scan.duration.raw());
  into.range_max = scan.maxRange;
  into.known = true;
  return true;
}

void ScanMerger::forget(std::size_t source) {
  if (source >= kSourcesMax) return;
  sources_[source].points.clear();
  sources_[source].known = false;
}

void ScanMerger::collect(const Source& source, std::int16_t segment, const Pose& odometry) {
  const double c = std::cos(odometry.rho);
  const double s = std::sin(odometry.rho);
  for (const Point& point : source.points) {
    const double dx = point.x - odometry.x;
    const double dy = point.y - odometry.y;
    const double x = dx * c + dy * s;
    const double y = dy * c - dx * s;
    seen_.push_back({.angle = std::atan2(y, x),
                     .point = {.x = whole_millimetres(x),
                               .y = whole_millimetres(y),
                               .z = whole_millimetres(std::hypot(x, y)),
                               .type = point.type,
                               .segment = segment,
                               .intensity = point.intensity}});
  }
}

bool ScanMerger::merge(TimeStamp now, const Pose& odometry, Scan2dData& merged) {
  if (!std::isfinite(odometry.x + odometry.y + odometry.rho)) return false;
  seen_.clear();
  merged.points.clear();
  merged.recordingTime = now;
  merged.maxRange = 0;
  merged.sectorNum = 1;
  merged.sectorIndex = 0;
  std::chrono::milliseconds age(0);
  bool any = false;
  for (std::size_t i = 0; i < kSourcesMax; ++i) {
    const Source& source = sources_[i];
    if (!source.known) continue;
    any = true;
    age = std::max(age, std::chrono::milliseconds(now - source.oldest));
    merged.maxRange = std::max(merged.maxRange.raw(), source.range_max);
    collect(source, static_cast<std::int16_t>(i + 1), odometry);
  }
  merged.duration = static_cast<u32>(age.count());
  std::ranges::sort(seen_, {}, &Seen::angle);
  const std::size_t count = std::min(seen_.size(), kPointsMax);
  left_out_ = seen_.size() - count;
  for (std::size_t i = 0; i < count; ++i)
    merged.points.push_back(seen_[i * seen_.size() / count].point);
  return any;
}

}  // namespace rack::perception
