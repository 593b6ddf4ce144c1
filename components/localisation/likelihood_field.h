// Likelihood field: how well the end point of a laser beam fits a map, by a table look-up (Thrun,
// Burgard, Fox: Probabilistic Robotics, section 6.4). Pure.
//
// The nearer the map has an obstacle to the end point, the better the beam fits. The space between
// scanner and obstacle is not checked; that makes the model fast, and smooth over poses that are
// slightly wrong. The distance of each cell to the nearest occupied one is computed once per map
// (Felzenszwalb and Huttenlocher 2012: two passes of lower envelopes of parabolas, exact). For a
// floor plan it is the distance of the cell's centre to the nearest wall, since the cells of a wall
// are up to half a cell beside it. A beam at distance d then has the likelihood
//   p(d) = hit * exp(-d^2 / (2 sigma^2)) + (1 - hit),
// whose second part stands for people and everything else that is not in the map. The table holds
// its logarithm in 8 bits, 0 for the farthest and 255 for d = 0, so that a beam costs one byte read
// and one addition.
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
  double sigma = 120;  // mm: combined noise of ranges, map and cells
  double hit = 0.97;   // share of beams that the map explains
};

// The end of a beam, in the frame of the robot, mm.
struct BeamEnd {
  float x;
  float y;
};

// End points as a structure of arrays: all x, then all y.
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
  // Refuses maps without an occupied or without a free cell.
  static tims::Result<LikelihoodField> of(const GridMap& map, const FieldSettings& settings);

  // How well a beam with this end point fits, 0 to 255; 0 outside of the map.
  [[nodiscard]] std::uint8_t at(float x, float y) const { return table_[index(x, y)]; }
  // Distance to the nearest obstacle of the map, mm, up to the limit of the table.
  [[nodiscard]] double distance(double x, double y) const;
  // log(p(0) / p(far)): the ratio of the best to the worst beam.
  [[nodiscard]] float log_ratio() const { return log_ratio_; }

  // The sum of at() over all beams measured at x, y, with sine and cosine of rho.
  [[nodiscard]] std::uint32_t sum(float x, float y, float sine, float cosine,
                                  const Beams& beams) const;
  // The same as a share of the maximum, 0 to 1.
  [[nodiscard]] double fit(const Pose& pose, const Beams& beams) const;

  // The share of beams that would have passed through a wall if measured from `pose`, 0 to 1.
  [[nodiscard]] double blocked(const Pose& pose, const Beams& beams) const;

  [[nodiscard]] bool is_free(double x, double y) const;
  [[nodiscard]] std::size_t free_cells() const { return free_.size(); }
  [[nodiscard]] double resolution() const { return resolution_; }
  // A random point in a random free cell.
  [[nodiscard]] MapPoint draw_free(Random& random) const;

 private:
  LikelihoodField() = default;
  template <bool kIsHuge>
  [[nodiscard]] std::uint32_t sum_of(float x, float y, float sine, float cosine,
                                     const Beams& beams) const;
  [[nodiscard]] bool is_blocked(const Pose& from, const MapPoint& end) const;
  // The index of the cell, in a table with a border that is far from all obstacles. max(0, x) is 0
  // when x is not a number.
  [[nodiscard]] std::size_t index(float x, float y) const {
    const float row = std::min(std::max(0.0F, (x - low_x_) * cells_per_mm_), row_max_);
    const float column = std::min(std::max(0.0F, (y - low_y_) * cells_per_mm_), column_max_);
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(stride_) +
           static_cast<std::size_t>(column);
  }

  std::vector<std::uint8_t> table_;
  std::vector<std::uint32_t> free_;  // indices of free cells in the table
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
  std::uint8_t wall_ = 0;  // from this value on, the cell contains an obstacle
};

}  // namespace rack::localisation
