// How far the pose of a keyframe can be wrong relative to earlier ones. Pure.
//
// The error grows along the way between the two: the heading drifts, and each error of the heading
// moves all that comes later, the more the farther away it is. The way is the shortest one, over
// loops that are closed ("Dijkstra projection": Bosse, Newman, Leonard, Soika, Feiten, Teller
// 2003): where the robot has been twice, what it drove in between does not count.
#pragma once

#include <span>
#include <vector>

#include "components/mapping/keyframes.h"
#include "components/mapping/scan_search.h"

namespace rack::mapping {

class Uncertainty {
 public:
  Uncertainty(const Track& track, std::span<const Edge> loops);

  // Of all keyframes relative to `at`.
  void look_from(std::size_t at);
  // The window that contains the true relative pose of a keyframe.
  [[nodiscard]] Window window(std::size_t place) const;
  // mm of travel without a loop between `at` and a keyframe.
  [[nodiscard]] double way(std::size_t place) const;

 private:
  // A keyframe for each metre.
  struct Station {
    double x;
    double y;
    std::vector<std::pair<std::size_t, double>> next{};  // station, mm
  };
  // Sums along the way: its length, and the places relative to `at`, weighted by length.
  struct Sums {
    double way = 1e12;
    double x = 0;
    double y = 0;
  };
  void connect(std::size_t a, std::size_t b, double mm);

  std::vector<std::size_t> station_of_;  // of each keyframe
  std::vector<Station> stations_;
  std::vector<Sums> sums_;
  double x_ = 0;
  double y_ = 0;
};

}  // namespace rack::mapping
