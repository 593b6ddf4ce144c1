// Finds the pose of a scan relative to other scans without a good initial pose, by branch and bound
// (Olson 2009 for the look-up grid; Hess, Kohler, Rapp, Andor 2016 for the search). Pure.
//
// The points of the other scans are drawn into a blurred grid of the likelihood that a beam ends in
// a cell. The score of a pose is the mean over the cells of its points. For each direction of the
// window, all shifts are covered by a hierarchy: each cell of the second grid has the maximum of 2
// x 2 cells, of the third 4 x 4, and so on. A score in such a grid is an upper bound for all shifts
// of the square; when it is below the best score so far, the whole square is skipped. The result is
// the exact optimum.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "components/mapping/scan_match.h"

namespace rack::mapping {

struct Window {
  double distance = 1000;  // mm, to all four sides
  double turn = 0.2;       // rad, to both sides
};

class ScanSearch {
 public:
  explicit ScanSearch(std::span<const ScanPoint2d> others);

  struct Found {
    Pose pose{};
    double score = 0;  // 0 to 1
  };
  // The best pose around `middle`, if its score is above `least`.
  [[nodiscard]] std::optional<Found> find(std::span<const ScanPoint2d> scan, const Pose& middle,
                                          const Window& window, double least) const;

  static constexpr double kCell = 50;  // mm

 private:
  struct Offset {
    std::int32_t row;
    std::int32_t column;
  };
  struct Square {
    std::int32_t row;
    std::int32_t column;
    std::uint32_t sum;
  };
  struct Turned;
  [[nodiscard]] std::size_t cell(std::int32_t row, std::int32_t column) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }
  void draw(const ScanPoint2d& point);
  void widen(std::size_t level);
  [[nodiscard]] std::uint32_t sum(std::size_t level, std::span<const Offset> points,
                                  std::int32_t row, std::int32_t column) const;
  void descend(const Turned& turned, std::size_t level, const Square& square,
               std::uint32_t& best_sum, std::optional<Square>& best) const;

  std::int32_t rows_ = 0;
  std::int32_t columns_ = 0;
  double low_x_ = 0;
  double low_y_ = 0;
  std::vector<std::vector<std::uint8_t>> levels_;
};

}  // namespace rack::mapping
