// Finds the pose of a scan relative to other scans without a good initial pose, by branch and bound
// (Olson 2009 for the look-up grid; Hess, Kohler, Rapp, Andor 2016 for the search). Pure.
//
// The points of the other scans are drawn into a blurred grid of the likelihood that a beam ends in
// a cell. The score of a pose is the mean over the cells of its points. For each direction of the
// window, all shifts are covered by a hierarchy: each cell of the second grid has the maximum of 2
// x 2 cells, of the third 4 x 4, and so on. A score in such a grid is an upper bound for all shifts
// of the square, less what the smallest shift of the square costs (poses far from the expected one
// are less probable); when it is below the best score so far, the whole square is skipped. The
// result is the exact optimum among the directions that are tried: in a window of many degrees
// these are the ones that turn the walls of the scan to the directions of the other walls.
#pragma once

#include <array>
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

// Poses that are not wanted: nearer than `distance` to `pose`.
struct Except {
  Pose pose{};
  double distance = 0;  // mm; 0: all are wanted
};

class ScanSearch {
 public:
  // Coarser cells (mm) and more levels of the hierarchy are for large windows.
  explicit ScanSearch(std::span<const ScanPoint2d> others, double cell = kCell,
                      std::size_t levels = kLevels);

  struct Found {
    Pose pose{};
    double score = 0;  // 0 to 1
  };
  // The best pose around `middle`, if its score is above `least`.
  [[nodiscard]] std::optional<Found> find(std::span<const ScanPoint2d> scan, const Pose& middle,
                                          const Window& window, double least,
                                          const Except& except = {}) const;

  static constexpr double kCell = 50;        // mm
  static constexpr std::size_t kLevels = 6;  // squares of the last level have sides of 32 cells

 private:
  // How many points have a wall of each direction.
  static constexpr std::size_t kDirections = 180;
  using Directions = std::array<float, kDirections>;
  static Directions directions_of(std::span<const ScanPoint2d> points);
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
  [[nodiscard]] std::uint32_t sum(std::size_t level, const Turned& turned, std::int32_t row,
                                  std::int32_t column) const;
  void descend(const Turned& turned, std::size_t level, const Square& square,
               std::uint32_t& best_sum, std::optional<Square>& best) const;
  void turn(std::span<const ScanPoint2d> scan, const Pose& middle, double rho,
            Turned& turned) const;
  [[nodiscard]] std::vector<double> turns(std::span<const ScanPoint2d> scan, double middle,
                                          double window) const;

  double cell_;
  double turn_step_;
  Directions directions_{};
  std::int32_t rows_ = 0;
  std::int32_t columns_ = 0;
  double low_x_ = 0;
  double low_y_ = 0;
  std::vector<std::vector<std::uint8_t>> levels_;
};

}  // namespace rack::mapping
