// Detects motion without a map: a moving object is at a place that an earlier scan saw as free.
// Pure.
//
// It keeps earlier scans as tables of free space (free_table.h): all of the newest five seconds,
// and every fourth of the 20 seconds before, so that a scanner with 180 degrees still remembers the
// space behind the robot. Each point of a new scan is looked up in them. It has moved if at least
// two kept scans saw well beyond it, and no fewer of them than have hit something there: thin
// furniture legs are hit by one scan and missed by the next. A static object was never seen
// through, whatever it is; a person that stops becomes part of the room when more scans have hit
// them than saw the place empty. A kept scan that half of the new one contradicts was recorded at a
// wrong pose of the odometry, and is dropped. The same look-up gives since when something has been
// at a place, so that an object that has just arrived there is not confused with it.
//
// A new scan is first aligned with four of the kept ones, of different ages: with the newest alone,
// errors would accumulate, and within 20 s a static object would appear to move.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "components/perception/free_table.h"
#include "components/perception/scan_view.h"

namespace rack::perception {

class FreeMemory {
 public:
  FreeMemory();

  // The pose near `robot` at which the scan fits the kept ones best.
  [[nodiscard]] Pose lay_on(const ScanView& scan, const Pose& robot) const;
  // Marks the sights of the scan that have moved, and keeps the scan if it is time for it.
  // `seconds`: its time, not less than that of the last one.
  void look(ScanView& scan, double seconds);
  void forget();
  // The free space of the last scan.
  [[nodiscard]] const FreeTable& now() const { return now_table_; }

 private:
  static constexpr std::size_t kFramesMax = 24;
  static constexpr std::ptrdiff_t kNewest = 12;  // frames that are all kept
  static constexpr std::uint32_t kOldApart = 4;  // of older frames every fourth is kept
  struct Frame {
    std::uint32_t number = 0;
    double seconds = 0;
    bool valid = false;
    FreeTable table{};
  };
  void compare(const FreeTable& table, const std::vector<Sight>& sights);
  void keep(double seconds);
  [[nodiscard]] double misfit(const ScanView& scan, const Pose& robot, std::size_t step) const;

  FreeTable now_table_;
  std::vector<Frame> frames_;
  std::vector<std::size_t> order_;  // indices of frames, the newest first
  std::uint32_t next_ = 0;          // number of the next frame
  double kept_ = 0;                 // s, time of the newest frame
  bool any_ = false;
  std::vector<std::uint8_t> through_;  // number of frames that saw through each sight
  std::vector<std::uint8_t> met_;      // number of frames that hit something there
  std::vector<std::uint8_t> now_;      // the same for one frame
  std::vector<std::uint8_t> met_now_;
};

}  // namespace rack::perception
