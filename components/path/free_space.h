// Free space: a grid map with the distance of each cell to the nearest obstacle. Pure.
//
// The distance transform is exact: first each column computes the distance to the nearest obstacle
// in that column, then each row finds the lower envelope of the parabolas over its cells
// (Felzenszwalb and Huttenlocher, Distance Transforms of Sampled Functions, 2012). This takes a few
// operations per cell, once per map. A collision check of the vehicle is then one look-up for each
// of the discs that cover its hull.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "components/geometry/pose.h"
#include "components/localisation/floor_plan.h"
#include "rack/proxies/grid_map.h"
#include "tims/result.h"

namespace rack::path {

// A hull as discs along its axis.
class HullDiscs {
 public:
  struct Size {
    double front = 0;  // of the hull, from the reference point, mm
    double back = 0;
    double half_width = 0;
    double margin = 0;  // around the hull
  };
  explicit HullDiscs(const Size& size);

  static constexpr std::size_t kMax = 8;
  [[nodiscard]] std::span<const double> centers() const { return {centers_.data(), count_}; }
  [[nodiscard]] double radius() const { return radius_; }
  // Radius of a disc around the reference point that covers the hull in any heading.
  [[nodiscard]] double turning_radius() const { return turning_radius_; }
  // The same for all discs: with that clearance, room() is not negative for any heading.
  [[nodiscard]] double reach() const {
    return std::max(-centers_[0], centers_[count_ - 1]) + radius_;
  }
  [[nodiscard]] double half_width() const { return half_width_; }  // including the margin

 private:
  std::array<double, kMax> centers_{};  // ahead of the reference point
  std::size_t count_ = 0;
  double radius_ = 0;
  double turning_radius_ = 0;
  double half_width_ = 0;
};

struct Place {
  double x = 0;  // mm
  double y = 0;
};

class FreeSpace {
 public:
  static constexpr std::size_t kCellsMax = 4000000;
  static constexpr double kCellMin = 10;  // mm

  FreeSpace() = default;
  // A map of free cells with this corner. The error kTooBig suggests a remedy.
  static tims::Result<FreeSpace> empty(const Place& corner, double width, double height,
                                       double cell);
  static tims::Result<FreeSpace> of(const GridMapData& map);
  // From a drawing, with a margin of `around` mm.
  static tims::Result<FreeSpace> of(const DxfPlan& plan, double cell, double around);
  // From a map of other cells: what touches an occupied one is occupied; what is unknown is free.
  static tims::Result<FreeSpace> of(const localisation::GridMap& map, double cell);
  // From a file. Errors name it.
  static tims::Result<FreeSpace> of(const localisation::FloorPlan& plan, double cell,
                                    double around);

  // Frees all cells and moves the map to another corner.
  void clear(const Place& corner);
  void occupy(const Place& place);
  void occupy(const Place& from, const Place& to);
  // The cells that a rectangle touches.
  void occupy_area(const Place& least, const Place& most);
  // Frees the cell at this place.
  void release(const Place& place);
  // Computes the distances; changes of cells have no effect before.
  void measure();

  [[nodiscard]] double cell() const { return cell_; }
  [[nodiscard]] std::size_t rows() const { return rows_; }        // along x
  [[nodiscard]] std::size_t columns() const { return columns_; }  // along y
  [[nodiscard]] Place corner() const { return corner_; }
  [[nodiscard]] Place center_of(std::size_t row, std::size_t column) const;
  // In cells of the same size or, where there are too many for the message, of a multiple of it:
  // one is occupied when a part of it is.
  [[nodiscard]] GridMapData message() const;
  [[nodiscard]] bool contains(const Place& place) const;
  [[nodiscard]] bool occupied(const Place& place) const;
  // Lower bound of the distance to the nearest obstacle, for any position of both within their
  // cells, mm. Space outside of the map is not free.
  [[nodiscard]] double clearance(const Place& place) const;
  // Distance between the hull and the nearest obstacle, mm; negative: they overlap.
  [[nodiscard]] double room(const HullDiscs& hull, const Pose& at) const;
  // The minimum on the line between both places.
  [[nodiscard]] double clearance(const Place& from, const Place& to) const;

 private:
  [[nodiscard]] std::size_t index(const Place& place) const;
  void envelope();

  Place corner_{};
  double cell_ = 100;
  std::size_t rows_ = 0;
  std::size_t columns_ = 0;
  std::vector<std::uint8_t> cells_;
  std::vector<float> distances_;  // between centres of cells, mm
  // Buffers of measure(): a line of cells, the indices and starts of the parabolas, and the result.
  std::vector<double> line_;
  std::vector<std::size_t> at_;
  std::vector<double> begin_;
  std::vector<double> squares_;
};

}  // namespace rack::path
