// Where a scan fits beside other scans, to a few millimetres: from a pose nearby, by Gauss-Newton
// on the distances of points to lines (Chen and Medioni 1992; PL-ICP of Censi 2008). Pure.
//
// Each point of a scan has the direction of the wall that it lies on, from its neighbours in the
// scan. In turns each point is given the nearest point of the others whose wall looks the same way
// (the two sides of a thin wall are two walls), and the pose is moved so that points come to lie on
// the lines through these. Points count less the farther they are from their line (Tukey's
// weights), and at last not at all: people, doors that have moved.
//
// What is known of the result is the matrix of Gauss and Newton itself: in a corridor without doors
// it says that nothing is known of the way along it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "components/geometry/pose.h"
#include "components/localisation/likelihood_field.h"

namespace rack::mapping {

using localisation::BeamEnd;
using Information = Eigen::Matrix3d;  // inverse covariance of x, y, rho; mm, rad

struct ScanPoint2d {
  float x;
  float y;
  float nx;  // of length 1, towards the scanner; 0, 0: on no wall
  float ny;
  [[nodiscard]] bool on_wall() const { return nx != 0 || ny != 0; }
};

// Not more than a point each 40 mm.
std::vector<ScanPoint2d> points_of(std::span<const BeamEnd> scan, const Pose& scanner);
// Seen from `frame`.
void add_points(std::span<const ScanPoint2d> points, const Pose& frame,
                std::vector<ScanPoint2d>& to);

// Points by where they are.
class PointIndex {
 public:
  explicit PointIndex(std::span<const ScanPoint2d> points);

  [[nodiscard]] bool empty() const { return points_.empty(); }
  // The nearest one within kReach whose wall looks like that of `point`; nullptr: none.
  [[nodiscard]] const ScanPoint2d* nearest(const ScanPoint2d& point, float reach) const;

  static constexpr float kReach = 300;  // mm

 private:
  [[nodiscard]] std::size_t cell(float x, float y) const;

  float low_x_ = 0;
  float low_y_ = 0;
  std::int32_t rows_ = 0;
  std::int32_t columns_ = 0;
  std::vector<std::uint32_t> begin_;  // by cell: its first point
  std::vector<ScanPoint2d> points_;
};

// What is known of the pose beforehand.
struct Prior {
  Pose pose{};
  Information information{Information::Zero()};
};

struct Match {
  Pose pose{};
  Information information{Information::Zero()};  // of the points alone
  double share = 0;                              // of the points on walls that found their line
  double misfit = 0;                             // mm, of these, root of the mean square
  std::size_t points = 0;
};

// Nothing: too few points, or they have nothing in common.
std::optional<Match> match(const PointIndex& others, std::span<const ScanPoint2d> scan,
                           const Pose& start, const Prior& prior = {});

}  // namespace rack::mapping
