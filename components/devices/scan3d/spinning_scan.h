// Scans of space by scanners that spin about an upright axis: columns of points become messages,
// one a turn, or one a sector of the turn for who wants the newest sooner.
//
// A column is a flat scan of Scan3dData: all its beams at one moment. Scanners turn clockwise.
#pragma once

#include <span>

#include "components/devices/core/dialogue.h"
#include "rack/proxies/scan3d.h"

namespace rack::device {

struct SpinSettings {
  int sectors = 1;       // messages a turn
  i32 range_min = 0;     // mm; nearer is the vehicle itself
  i32 range_max = 0;     // mm; 0: as far as the scanner sees
  double direction = 0;  // where the scanner's front looks on the robot, clockwise, rad
};

class SpinningScan {
 public:
  explicit SpinningScan(const SpinSettings& settings);

  // Points of a column in `sector`: each is to be put(), they are those of an older scan.
  // `is_first`: it is known that the sector begins with this. Empty: there is no room for so many.
  std::span<ScanPoint> add(int sector, bool is_first, Time when, std::size_t points);
  // The sector is complete with the column that was added last.
  void end_sector();
  // Joined anew: what is there now is not whole.
  void clear();

  void set_device(i32 range_max, i32 hardware);
  [[nodiscard]] const SpinSettings& settings() const { return settings_; }

  // `range`, mm, at which place of the scanner's own frame: marks what is too near, too far.
  // RACK's axes: x ahead, y right, z down.
  void put(ScanPoint& point, i32 range, float x, float y, float z, i16 intensity) const {
    if (range > range_min_ && range <= range_max_)
      point = {.x = static_cast<i32>(x),
               .y = static_cast<i32>(y),
               .z = static_cast<i32>(z),
               .intensity = intensity};
    else
      point = {.type = range > range_max_ ? scan_point::kInvalid | scan_point::kMaxRange
                                          : scan_point::kInvalid,
               .intensity = intensity};
  }

  bool take(Scan3dData& scan, Time& recorded);
  [[nodiscard]] bool has_scan() const { return has_ready_; }
  // Scans that nobody took before the next was there.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }

 private:
  SpinSettings settings_;
  i32 range_min_;
  i32 range_max_;
  i32 hardware_ = 0;
  Scan3dData building_{};
  Scan3dData ready_{};
  std::size_t size_ = 0;  // of building_: what its points have behind that is of an older scan
  int sector_ = -1;
  bool is_whole_ = false;
  i32 columns_ = 0;
  Time first_{};
  Time last_{};
  Time ready_recorded_{};
  bool has_ready_ = false;
  std::uint64_t lost_ = 0;
};

}  // namespace rack::device
