// Obstacles that the scanner has seen and that no wall of the map explains. Pure.
//
// Each point of a scan marks a place, unless a wall of the map is near enough to explain it. A mark
// stays when the scanner looks elsewhere, and goes when a later scan looks through its place.
#pragma once

#include <span>
#include <vector>

#include "components/path/free_space.h"
#include "rack/proxies/scan2d.h"

namespace rack::path {

class SeenObstacles {
 public:
  static constexpr std::size_t kMost = 20000;  // marks; further points are ignored

  SeenObstacles();  // allocates all memory

  // Ignores the scan before; the marks stay.
  void begin() { seen_ = false; }
  void forget() { marks_.clear(); }
  // The newest scan, in the frame of the robot, and the pose of the robot.
  void take(const Scan2dData& scan, const Pose& from);
  // Brings the marks up to date with the newest scan. `space`: where marks are of interest, without
  // them; `map`: nullptr if there is none.
  void update(const FreeSpace& space, const FreeSpace* map);

  [[nodiscard]] std::span<const Place> marks() const { return marks_; }

 private:
  void forget_what_has_gone();
  void remember(const FreeSpace& space, const FreeSpace* map);

  Scan2dData scan_;
  Pose from_;
  bool seen_ = false;
  std::vector<Place> marks_;
};

}  // namespace rack::path
