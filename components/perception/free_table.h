// What one scan knows about a place: occupied, free, or hidden. Pure.
//
// A beam that ended at 5 m has shown that its path is free (the violation of free space, as used by
// Wang and Thorpe in 2002). A scan is stored as a table over directions around the scanner: the
// free distance, and the distance of the hit. A place is hit when its distance is that of the
// beam's end; it was seen through when the beam and its neighbours went well beyond it, since an
// edge is hit by one scan and missed by the next.
//
// Directions are compared without a trigonometric function: y / (|x| + |y|), continued around the
// turn, increases with the angle.
#pragma once

#include <array>
#include <cstdint>

#include "components/geometry/floor_map.h"
#include "components/perception/scan_view.h"

namespace rack::perception {

class FreeTable {
 public:
  enum class Seen : std::uint8_t { kHidden, kThrough, kMet };
  struct Distances {
    double free = 0;  // mm
    double met = 0;   // mm; 0: no hit
  };

  // ScanView::place() was called for the scan.
  void fill(const ScanView& scan);

  // The distances in the direction (dx, dy) from the scanner.
  [[nodiscard]] Distances towards(double dx, double dy) const;
  // What was seen at a place that extends `half` mm to both sides, and at least a beam.
  [[nodiscard]] Seen look(const MapPoint& at, double half) const;
  // The position of the scanner.
  [[nodiscard]] const MapPoint& from() const { return from_; }

  // `away`: distance of a place in that direction, mm.
  static bool is_through(const Distances& distances, double away);
  static bool is_met(const Distances& distances, double away);

 private:
  static constexpr std::size_t kDirections = 1440;
  using Table = std::array<float, kDirections>;
  static std::size_t direction(double x, double y);
  static void mark(Table& table, double x, double y, double half, float away);
  [[nodiscard]] Distances at(std::size_t direction) const;

  MapPoint from_{};
  double spread_ = 0;  // tangent of the angle between two beams
  Table met_{};        // mm, distance of the hit; 0: unknown
  Table free_{};       // mm, minimum over a direction and its neighbours
};

}  // namespace rack::perception
