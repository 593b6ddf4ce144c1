// How well the end of a laser beam fits a map, looked up at one place (Thrun, Burgard, Fox:
// Probabilistic Robotics, section 6.4, "likelihood field"). Pure.
//
// A beam ends at an obstacle, with some noise; the nearer the map has one, the better it fits. What
// is between scanner and obstacle is not looked at: that is what makes it fast, and smooth over
// poses that are slightly wrong. Once a map, the distance of each cell to the nearest occupied one
// is found (Felzenszwalb and Huttenlocher 2012: two passes of lower envelopes of parabolas, exact);
// of a floor plan, that of its middle to the nearest wall, as the cells that a wall is drawn in lie
// up to half a cell beside it.
// A beam at distance d then has the likelihood
//   p(d) = hit * exp(-d^2 / (2 sigma^2)) + (1 - hit),
// whose second part are people and all else that no map has. Kept is its logarithm in 8 bits, 0
// for the farthest and 255 for d = 0, so that a beam is one byte read and one addition.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "components/geometry/pose.h"
#include "components/geometry/random.h"
#include "components/localisation/grid_map.h"

namespace rack::localisation {

struct FieldSettings {
  double sigma = 120;  // mm: noise of ranges, of the map and of its cells together
  double hit = 0.97;   // share of beams that the map explains, as far as this one counts
};

// The end of a beam, in the frame of the robot, mm.
struct BeamEnd {
  float x;
  float y;
};

// Many of them, as a processor likes them: all x, then all y.
class Beams {
 public:
  void reserve(std::size_t count) {
    x_.reserve(count);
    y_.reserve(count);
  }
  void clear() {
    x_.clear();
    y_.clear();
  }
  void add(const BeamEnd& beam) {
    x_.push_back(beam.x);
    y_.push_back(beam.y);
  }
  [[nodiscard]] std::size_t size() const { return x_.size(); }
  [[nodiscard]] bool empty() const { return x_.empty(); }
  [[nodiscard]] const float* x() const { return x_.data(); }
  [[nodiscard]] const float* y() const { return y_.data(); }
  [[nodiscard]] BeamEnd operator[](std::size_t i) const { return {x_[i], y_[i]}; }

 private:
  std::vector<float> x_;
  std::vector<float> y_;
};

class LikelihoodField {
 public:
  // Refused: maps without an occupied or without a free cell.
  static tims::Result<LikelihoodField> of(const GridMap& map, const FieldSettings& settings);

  // How well a beam that ends there fits, 0 to 255. Beyond the map nothing fits.
  [[nodiscard]] std::uint8_t at(float x, float y) const { return table_[index(x, y)]; }
  // mm to the nearest obstacle of the map, as far as it is told apart.
  [[nodiscard]] double distance(double x, double y) const;
  // How much better the best beam is than the worst: log(p(0) / p(far)).
  [[nodiscard]] float log_ratio() const { return log_ratio_; }

  // The sum of at() over all beams seen from x, y, with sine and cosine of rho.
  [[nodiscard]] std::uint32_t sum(float x, float y, float sine, float cosine,
                                  const Beams& beams) const;
  // The same as a part of the most that is possible, 0 to 1.
  [[nodiscard]] double fit(const Pose& pose, const Beams& beams) const;

  // How many of the beams seen from there would have gone through a wall, as a part of all, 0 to 1.
  [[nodiscard]] double blocked(const Pose& pose, const Beams& beams) const;

  [[nodiscard]] bool is_free(double x, double y) const;
  [[nodiscard]] std::size_t free_cells() const { return free_.size(); }
  [[nodiscard]] double resolution() const { return resolution_; }
  // Somewhere in a free cell.
  [[nodiscard]] MapPoint draw_free(Random& random) const;

 private:
  LikelihoodField() = default;
  template <bool kIsHuge>
  [[nodiscard]] std::uint32_t sum_of(float x, float y, float sine, float cosine,
                                     const Beams& beams) const;
  [[nodiscard]] bool is_blocked(const Pose& from, const MapPoint& end) const;
  // Of the cell, in a table with a border that is far from everything. max(0, x) is 0 when x is no
  // number.
  [[nodiscard]] std::size_t index(float x, float y) const {
    const float row = std::min(std::max(0.0F, (x - low_x_) * cells_per_mm_), row_max_);
    const float column = std::min(std::max(0.0F, (y - low_y_) * cells_per_mm_), column_max_);
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(stride_) +
           static_cast<std::size_t>(column);
  }

  std::vector<std::uint8_t> table_;
  std::vector<std::uint32_t> free_;  // their places in the table
  double resolution_ = 0;
  double sigma_ = 0;
  double hit_ = 0;
  float low_x_ = 0;  // of the table, with its border
  float low_y_ = 0;
  float cells_per_mm_ = 0;
  float row_max_ = 0;
  float column_max_ = 0;
  std::int32_t stride_ = 0;
  float log_ratio_ = 0;
  std::uint8_t wall_ = 0;  // and more: an obstacle is in the cell
};

}  // namespace rack::localisation
