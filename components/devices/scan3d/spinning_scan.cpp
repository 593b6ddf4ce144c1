#include "components/devices/scan3d/spinning_scan.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace rack::device {

SpinningScan::SpinningScan(const SpinSettings& settings)
    : settings_(settings),
      range_min_(std::max(0, settings.range_min)),
      range_max_(settings.range_max > 0 ? settings.range_max : std::numeric_limits<i32>::max()) {
  building_.points.reserve_all();
  ready_.points.reserve_all();
}

void SpinningScan::set_device(i32 range_max, i32 hardware) {
  hardware_ = hardware;
  range_max_ = settings_.range_max > 0 ? std::min(settings_.range_max, range_max) : range_max;
}

std::span<ScanPoint> SpinningScan::add(int sector, bool is_first, Time when, std::size_t points) {
  if (sector != sector_ || is_first) {
    // A sector that follows another one is received from its start.
    const bool is_known = sector_ >= 0;
    end_sector();
    sector_ = sector;
    is_whole_ = is_known || is_first;
    first_ = when;
  }
  const std::size_t begin = size_;
  if (begin + points > kScan3dPointsMax) {
    is_whole_ = false;
    return {};
  }
  ++columns_;
  last_ = when;
  building_.scanPointNum = static_cast<i32>(points);
  size_ += points;
  // Existing points are not initialised again: this would take as long as setting them.
  if (building_.points.size() < size_) building_.points.resize(size_);
  return std::span(building_.points).subspan(begin, points);
}

void SpinningScan::end_sector() {
  if (is_whole_ && columns_ > 0) {
    constexpr auto kMillisecond = std::chrono::milliseconds(1);
    building_.duration = static_cast<u32>(std::max<Duration>(last_ - first_, {}) / kMillisecond);
    building_.maxRange = range_max_;
    building_.scanNum = columns_;
    building_.scanMode = scan_mode::kYaw | scan_mode::kPositiveTurn;
    building_.scanHardware = hardware_;
    building_.sectorNum = settings_.sectors;
    building_.sectorIndex = sector_;
    building_.refPos = {};
    building_.points.resize(size_);
    building_.pointNum = static_cast<i32>(size_);
    building_.compressed = 0;
    std::swap(building_, ready_);
    ready_recorded_ = first_ + (last_ - first_) / 2;
    lost_ += has_ready_ ? 1 : 0;
    has_ready_ = true;
  }
  size_ = 0;
  columns_ = 0;
  is_whole_ = false;
}

void SpinningScan::clear() {
  is_whole_ = false;
  end_sector();
  sector_ = -1;
  has_ready_ = false;
}

bool SpinningScan::take(Scan3dData& scan, Time& recorded) {
  if (!std::exchange(has_ready_, false)) return false;
  std::swap(scan, ready_);
  recorded = ready_recorded_;
  return true;
}

}  // namespace rack::device
