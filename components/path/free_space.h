// Where there is room: a map of cells, and for each how far it is to the nearest obstacle. Pure.
//
// The distances are exact: first each column tells its cells how far the nearest obstacle of that
// column is, then each row finds the lower envelope of the parabolas that stand over its cells
// (Felzenszwalb and Huttenlocher, Distance Transforms of Sampled Functions, 2012). That is a few
// operations a cell, once for each map; to ask whether a vehicle has room somewhere is then one
// look at a time for each of the discs that cover its hull.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "components/geometry/floor_map.h"
#include "components/geometry/pose.h"
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
    double margin = 0;  // around it
  };
  explicit HullDiscs(const Size& size);

  static constexpr std::size_t kMax = 8;
  [[nodiscard]] std::span<const double> centers() const { return {centers_.data(), count_}; }
  [[nodiscard]] double radius() const { return radius_; }
  // Of a disc about the reference point that covers it in any heading.
  [[nodiscard]] double turning_radius() const { return turning_radius_; }
  [[nodiscard]] double half_width() const { return half_width_; }  // with the margin

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
  // Free cells from a corner on. kTooBig says what to do.
  static tims::Result<FreeSpace> empty(const Place& corner, double width, double height,
                                       double cell);
  // occupied: from this value of the message on.
  static tims::Result<FreeSpace> of(const GridMapData& map, std::uint8_t occupied = 128);
  // Of a drawing, as FloorMap takes it, with `around` mm around it.
  static tims::Result<FreeSpace> of(const DxfDrawing& drawing, double scale, double offset_x,
                                    double offset_y, double cell, double around);

  // All of it is free, and lies elsewhere.
  void clear(const Place& corner);
  void occupy(const Place& place);
  void occupy(const Place& from, const Place& to);
  // Takes away what is occupied there.
  void release(const Place& place);
  // What was occupied counts only from here on.
  void measure();

  [[nodiscard]] double cell() const { return cell_; }
  [[nodiscard]] std::size_t rows() const { return rows_; }        // along x
  [[nodiscard]] std::size_t columns() const { return columns_; }  // along y
  [[nodiscard]] Place corner() const { return corner_; }
  [[nodiscard]] Place center_of(std::size_t row, std::size_t column) const;
  [[nodiscard]] bool contains(const Place& place) const;
  [[nodiscard]] bool occupied(const Place& place) const;
  // At least as far as this it is to the nearest obstacle, wherever in its cell that lies, mm.
  // Nothing is free outside.
  [[nodiscard]] double clearance(const Place& place) const;
  // By how much all of the hull keeps away from obstacles; negative: it does not, mm.
  [[nodiscard]] double room(const HullDiscs& hull, const Pose& at) const;
  // The smallest on the line between them.
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
  // For measure(): a line of cells, where parabolas stand, where they begin, and what comes out.
  std::vector<double> line_;
  std::vector<std::size_t> at_;
  std::vector<double> begin_;
  std::vector<double> squares_;
};

}  // namespace rack::path
