// What moves, without a map: it stands where an earlier scan has looked through. Pure.
//
// Some earlier scans are kept (free_table.h): the newest five seconds of them, and fewer of the 20
// seconds before, so that a scanner of half a turn still knows what it has looked away from. Each
// point of a new scan is looked up in them: it is one that has moved if at least two of them saw
// well beyond it, and no fewer than have met something there: thin legs of furniture are met by one
// scan and missed by the next. What has always stood there was never looked through, whatever it
// is; a person that stops becomes part of the room when more scans have met it than saw the place
// empty. A kept scan that half of the new one contradicts was made somewhere else than the odometry
// says, so that it is forgotten. The same look-up tells since when something has stood at a place:
// who has just come there is not it.
//
// A new scan is first laid on four of the kept ones, of different ages: on the newest alone, errors
// would add up, and in 20 s what stands would have moved.
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

  // The pose near this one from which the scan fits the kept ones best.
  [[nodiscard]] Pose lay_on(const ScanView& scan, const Pose& robot) const;
  // Says of each sight of the scan whether it has moved, and keeps the scan if it is time for it.
  // `seconds`: its time, not less than the last.
  void look(ScanView& scan, double seconds);
  void forget();
  // What the last scan saw.
  [[nodiscard]] const FreeTable& now() const { return now_table_; }

 private:
  static constexpr std::size_t kFramesMax = 24;
  static constexpr std::ptrdiff_t kNewest = 12;  // all that were kept
  static constexpr std::uint32_t kOldApart = 4;  // of older ones each so many-th
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
  std::vector<std::size_t> order_;  // of the frames, the newest first
  std::uint32_t next_ = 0;          // number of the next one
  double kept_ = 0;                 // when the newest was
  bool any_ = false;
  std::vector<std::uint8_t> through_;  // frames that looked through each sight
  std::vector<std::uint8_t> met_;      // and that met something there
  std::vector<std::uint8_t> now_;      // of one frame
  std::vector<std::uint8_t> met_now_;
};

}  // namespace rack::perception
