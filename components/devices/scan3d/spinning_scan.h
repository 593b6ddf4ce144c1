// Assembles the columns of a 3D scanner with a vertical axis to messages: one per turn, or one per
// sector of a turn for a lower latency.
//
// A column is a flat scan of Scan3dData: all beams at one time. Scanners turn clockwise.
#pragma once

#include <span>

#include "rack/devices/dialogue.h"
#include "rack/proxies/scan3d.h"

namespace rack::device {

struct SpinSettings {
  int sectors = 1;       // messages per turn
  i32 range_min = 0;     // mm; nearer points belong to the vehicle itself
  i32 range_max = 0;     // mm; 0: range of the scanner
  double direction = 0;  // direction of the scanner's front on the robot, clockwise, rad
};

class SpinningScan {
 public:
  explicit SpinningScan(const SpinSettings& settings);

  // Returns the points of a new column in `sector`. They contain old values, so each must be set
  // with put(). `is_first`: the column is the first of its sector. Empty if the capacity is
  // exceeded.
  std::span<ScanPoint> add(int sector, bool is_first, Time when, std::size_t points);
  // The column added last completes its sector.
  void end_sector();
  // Restarts in the middle of a turn: the current sector is incomplete.
  void clear();

  void set_device(i32 range_max, i32 hardware);
  [[nodiscard]] const SpinSettings& settings() const { return settings_; }

  // Sets a point with `range`, mm, and position in the scanner's frame; marks points that are too
  // near or too far. Axes of RACK: x ahead, y right, z down.
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
  // Number of scans not taken before the next one was complete.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }

 private:
  SpinSettings settings_;
  i32 range_min_;
  i32 range_max_;
  i32 hardware_ = 0;
  Scan3dData building_{};
  Scan3dData ready_{};
  std::size_t size_ = 0;  // points used in building_; those behind belong to an older scan
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
