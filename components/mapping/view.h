// What a scan saw around it: how far it is free in each direction. Pure.
//
// Walls of other scans are compared with it. A wall that is nearer than what this scan saw behind
// it cannot be there: the poses of the two scans contradict each other, however well their lines
// fit. Rooms and corridors that look alike are told apart by this, and maps that are folded over
// themselves are recognised. People and doors contradict as well, but only with few points.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "components/mapping/scan_match.h"

namespace rack::mapping {

// The number of points of walls that a scan saw at their place, and through.
struct Agreement {
  std::size_t seen = 0;
  std::size_t seen_through = 0;

  void add(const Agreement& other) {
    seen += other.seen;
    seen_through += other.seen_through;
  }
  // Of all points that the scan says anything about.
  [[nodiscard]] double contradiction() const {
    const std::size_t all = seen + seen_through;
    return all == 0 ? 0 : static_cast<double>(seen_through) / static_cast<double>(all);
  }
};

enum class Seen : std::uint8_t { kUnknown, kThere, kThrough };

class View {
 public:
  View() = default;
  View(std::span<const BeamEnd> scan, const Pose& scanner);

  // A point of a wall, in the frame of the robot.
  [[nodiscard]] Seen judge(double x, double y) const;
  // Points of walls in the frame of another robot, whose pose relative to this one is `frame`.
  [[nodiscard]] Agreement judge(std::span<const ScanPoint2d> points, const Pose& frame) const;

 private:
  static constexpr std::size_t kBearings = 360;

  double x_ = 0;  // of the scanner
  double y_ = 0;
  std::array<float, kBearings> nearest_{};  // mm; 0: nothing is known
};

}  // namespace rack::mapping
