// Where a scan fits beside lines that are known, to a few millimetres: from a pose nearby, by
// Gauss-Newton on the distances of points to lines (Chen and Medioni 1992; PL-ICP of Censi 2008).
// The lines are the points of other scans, or the walls of a map. Pure.
//
// Each point of a scan has the direction of the wall that it lies on, from its neighbours in the
// scan. In turns each point is given the nearest line that looks the same way, and the pose is
// moved so that points come to lie on their lines. Points count less the farther they are from
// their line (Tukey's weights), and at last not at all: people, doors that have moved.
//
// What is known of the result is the matrix of Gauss and Newton itself: in a corridor without doors
// it says that nothing is known of the way along it. How much a point errs is taken as known, or
// measured by how far points lie from their lines; neighbours that lie on the same side together
// count as one then.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "components/geometry/pose.h"
#include "components/localisation/likelihood_field.h"

namespace rack::localisation {

using Information = Eigen::Matrix3d;  // inverse covariance of x, y, rho; mm, rad

struct ScanPoint2d {
  float x;
  float y;
  float nx;  // of length 1, towards the scanner; 0, 0: on no wall
  float ny;
  [[nodiscard]] bool on_wall() const { return nx != 0 || ny != 0; }
};

// Not more than a point each 40 mm, of each so many-th beam.
void points_of(std::span<const BeamEnd> scan, const Pose& scanner, std::size_t every,
               std::vector<ScanPoint2d>& points);

// What points are laid on.
class Lines {
 public:
  virtual ~Lines() = default;
  [[nodiscard]] virtual bool empty() const = 0;
  // The one that is nearest to the point, within `reach` mm, and looks like its wall: a point of it
  // and its direction. nullptr: none.
  [[nodiscard]] virtual const ScanPoint2d* nearest(const ScanPoint2d& point, float reach) const = 0;

 protected:
  Lines() = default;
  Lines(const Lines&) = default;
  Lines(Lines&&) = default;
  Lines& operator=(const Lines&) = default;
  Lines& operator=(Lines&&) = default;
};

// What is known of the pose beforehand.
struct Prior {
  Pose pose{};
  Information information{Information::Zero()};
};

struct MatchSettings {
  double reach = 300;  // mm, to begin with
  // A direction that fewer points tell of stays as it is (of rho a mm at a metre away): a nail in
  // the wall of a corridor says nothing.
  double tell_least = 0;
  bool measures_noise = false;
  // However many points, a match errs so much: scanners are bent, robots sway, maps have cells.
  double least_way = 6;               // mm
  double least_turn = radians(0.12);  // rad
};

struct Match {
  Pose pose{};
  Information information{Information::Zero()};  // of the points alone
  double share = 0;                              // of the points on walls that found their line
  double misfit = 0;                             // mm, of these, root of the mean square
  std::size_t points = 0;
};

// Nothing: too few points, or they have nothing in common. Allocates nothing.
std::optional<Match> match(const Lines& lines, std::span<const ScanPoint2d> scan, const Pose& start,
                           const Prior& prior = {}, const MatchSettings& settings = {});

}  // namespace rack::localisation
