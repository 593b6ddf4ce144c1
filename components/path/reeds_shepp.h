// The shortest path of a car between two poses without obstacles. Pure.
//
// A car with a minimum turning radius that drives in both senses can reach any pose, and the
// shortest path has at most five pieces: lines, and arcs of that radius (Reeds and Shepp, Optimal
// paths for a car that goes both forwards and backwards, Pacific Journal of Mathematics 145, 1990,
// formulas 8.1 to 8.11). There are nine families; each is solved for the pose itself, with forward
// and backward exchanged, with left and right exchanged, with both, and some of them from the other
// end. The shortest solution wins.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "components/geometry/pose.h"

namespace rack::path {

// A part of a path: an arc, or a line with curvature 0.
struct Piece {
  double curvature = 0;  // 1/mm, positive to the right
  double length = 0;     // mm, negative backward
};

class ReedsShepp {
 public:
  ReedsShepp(const Pose& from, const Pose& to, double radius);

  [[nodiscard]] double length() const { return length_; }  // mm
  [[nodiscard]] std::span<const Piece> pieces() const { return {pieces_.data(), count_}; }

 private:
  static constexpr std::size_t kPiecesMax = 5;
  std::array<Piece, kPiecesMax> pieces_{};
  std::size_t count_ = 0;
  double length_ = 0;
};

// The pose at the end of a piece.
Pose driven(const Pose& from, const Piece& piece);

}  // namespace rack::path
