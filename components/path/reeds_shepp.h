// The shortest way of a car between two poses, where nothing is in its way. Pure.
//
// A car that turns with a smallest radius and drives in both senses gets anywhere, and the shortest
// way is made of at most five pieces: lines, and arcs of that radius (Reeds and Shepp, Optimal
// paths for a car that goes both forwards and backwards, Pacific Journal of Mathematics 145, 1990,
// whose formulas 8.1 to 8.11 these are). There are nine families; each is solved for the pose as it
// is, with forward and backward exchanged, with left and right, with both, and some of them driven
// from the other end. The shortest of what is found wins.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "components/geometry/pose.h"

namespace rack::path {

// A part of a way: an arc, or a line with curvature 0.
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

// Where a piece leads to.
Pose driven(const Pose& from, const Piece& piece);

}  // namespace rack::path
