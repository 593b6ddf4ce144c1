// What one scan says about places: that something stood there, that nothing did, or neither. Pure.
//
// A beam that ended at 5 m has seen that nothing stood on its way (the violation of free space, as
// Wang and Thorpe used it in 2002). A scan is kept as a table of directions around the scanner: how
// far it was free, and how far away something was met. A place is met when it is as far away as
// what the beam there ended at; it was looked through when the beam and its neighbours went well
// beyond it, since an edge is hit by one scan and missed by the next.
//
// Directions are told apart without a trigonometric function: y / (|x| + |y|), continued around
// the turn, grows with the angle.
#pragma once

#include <array>
#include <cstdint>

#include "components/geometry/floor_map.h"
#include "components/perception/scan_view.h"

namespace rack::perception {

class FreeTable {
 public:
  enum class Seen : std::uint8_t { kHidden, kThrough, kMet };
  struct Ways {
    double free = 0;  // mm
    double met = 0;   // mm; 0: nothing
  };

  // The scan has its place.
  void fill(const ScanView& scan);

  // In the direction of this way from the scanner.
  [[nodiscard]] Ways towards(double dx, double dy) const;
  // A place that is as much as `half` mm wide to both sides, and a beam at least.
  [[nodiscard]] Seen look(const MapPoint& at, double half) const;
  // Where the scanner was.
  [[nodiscard]] const MapPoint& from() const { return from_; }

  // `away`: mm, of a place in that direction.
  static bool is_through(const Ways& ways, double away);
  static bool is_met(const Ways& ways, double away);

 private:
  static constexpr std::size_t kDirections = 1440;
  using Table = std::array<float, kDirections>;
  static std::size_t direction(double x, double y);
  static void say(Table& table, double x, double y, double half, float away);
  [[nodiscard]] Ways at(std::size_t direction) const;

  MapPoint from_{};
  double spread_ = 0;  // tangent of the angle between two beams
  Table met_{};        // mm, to what stood there; 0: nothing is known
  Table free_{};       // the least of this and of its neighbours
};

}  // namespace rack::perception
