// What moves, without a map: it stands where an earlier scan has looked through. Pure.
//
// A beam that ended at 5 m has seen that nothing stood on its way (the violation of free space, as
// Wang and Thorpe used it in 2002). Some earlier scans are kept, each as a table of how far it was
// free in each direction, and each point of a new scan is looked up in them: it is one that has
// moved if at least two of them saw well beyond it, and no fewer than have met something there:
// thin legs of furniture are met by one scan and missed by the next. What has always stood there
// was never looked through, whatever it is; a person that stops becomes part of the room when the
// last scan that saw the place empty is forgotten. Neighbouring beams must agree, since an edge is
// hit by one scan and missed by the next; and a kept scan that half of the new one contradicts was
// made somewhere else than the odometry says, so that it is forgotten. The same look-up tells since
// when something has stood at a place: who has just come there is not it.
//
// Directions are told apart without a trigonometric function: y / (|x| + |y|), continued around
// the turn, grows with the angle.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

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

 private:
  static constexpr std::size_t kFramesMax = 12;
  static constexpr std::size_t kDirections = 1440;
  struct Frame {
    double seconds = 0;
    double x = 0;  // of the scanner, mm
    double y = 0;
    bool valid = false;
    std::array<float, kDirections> met{};   // mm, to what stood there; 0: nothing is known
    std::array<float, kDirections> free{};  // the least of this and of its neighbours
  };
  static std::size_t direction(double x, double y);
  void compare(const Frame& frame, double age, std::vector<Sight>& sights);
  void keep(const ScanView& scan, double seconds);
  [[nodiscard]] double misfit(const ScanView& scan, const Pose& robot, std::size_t step) const;

  std::vector<Frame> frames_;
  std::size_t next_ = 0;
  double kept_ = 0;  // when the newest was
  bool any_ = false;
  std::vector<std::uint8_t> through_;  // frames that looked through each sight
  std::vector<std::uint8_t> met_;      // and that met something there
  std::vector<std::uint8_t> now_;      // of one frame
  std::vector<std::uint8_t> met_now_;
};

}  // namespace rack::perception
