// Matches a scan against known lines, with an accuracy of a few millimetres: from a pose nearby, by
// Gauss-Newton on point-to-line distances (Chen and Medioni 1992; PL-ICP of Censi 2008). The lines
// are the points of other scans, or the walls of a map. Pure.
//
// Each point of a scan has the direction of the wall that it is on, from its neighbours in the
// scan. The iteration alternates between two steps: it assigns to each point the nearest line of
// similar direction, then moves the pose so that the points come to lie on their lines. The weight
// of a point decreases with its distance to its line down to 0 (Tukey's weights): people, doors
// that have moved.
//
// The information matrix of the result is that of Gauss-Newton: in a corridor without doors it has
// no information along the corridor. The error of a point is either a constant or estimated from
// the residuals; then neighbours with residuals of the same sign count as one.
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
  float nx;  // unit normal towards the scanner; 0, 0: not on a wall
  float ny;
  [[nodiscard]] bool on_wall() const { return nx != 0 || ny != 0; }
};

// The points of every `every`-th beam, thinned to one point per 40 mm.
void points_of(std::span<const BeamEnd> scan, const Pose& scanner, std::size_t every,
               std::vector<ScanPoint2d>& points);

// The lines that points are matched against.
class Lines {
 public:
  virtual ~Lines() = default;
  [[nodiscard]] virtual bool empty() const = 0;
  // The nearest line within `reach` mm that has a similar direction: a point on it and its normal.
  // nullptr: there is none.
  [[nodiscard]] virtual const ScanPoint2d* nearest(const ScanPoint2d& point, float reach) const = 0;

 protected:
  Lines() = default;
  Lines(const Lines&) = default;
  Lines(Lines&&) = default;
  Lines& operator=(const Lines&) = default;
  Lines& operator=(Lines&&) = default;
};

// Prior knowledge of the pose.
struct Prior {
  Pose pose{};
  Information information{Information::Zero()};
};

struct MatchSettings {
  double reach = 300;  // mm, in the first iteration
  // A direction that is determined by fewer points than this is not corrected (a rotation counts at
  // 1 m distance): a single nail in the wall of a corridor does not determine the position along
  // it.
  double least_information = 0;
  bool measures_noise = false;
  // The minimum error of a match, for any number of points: scanners are bent, robots sway, maps
  // have cells.
  double least_distance = 6;          // mm
  double least_turn = radians(0.12);  // rad
};

struct Match {
  Pose pose{};
  Information information{Information::Zero()};  // of the points alone
  double share = 0;                              // of the points on walls that have a line
  double misfit = 0;                             // mm, RMS of their residuals
  std::size_t points = 0;
};

// Nothing: too few points, or none of them match. Allocates nothing.
std::optional<Match> match(const Lines& lines, std::span<const ScanPoint2d> scan, const Pose& start,
                           const Prior& prior = {}, const MatchSettings& settings = {});

}  // namespace rack::localisation
