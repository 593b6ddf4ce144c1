#include "components/localisation/scan_matcher.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace rack::localisation {

namespace {

constexpr std::size_t kPoints = 180;     // about
constexpr double kLeastInformation = 8;  // points that determine a direction
constexpr double kShareLeast = 0.5;      // of the points, on walls
constexpr double kMisfitMost = 60;       // mm
constexpr double kScanMatcherFarthest =
    16.3;  // squared Mahalanobis distance: 99.9 % for 3 degrees of freedom
constexpr double kLeastDistance = 2;  // mm: minimum error of a match with a perfect map
constexpr double kLeastTurn = radians(0.02);
// Minimum standard deviation of the prior, however small that of the filter is.
constexpr double kSpreadDistance = 10;  // mm
constexpr double kSpreadTurn = radians(0.3);
constexpr double kReachLeast = 100;  // mm
constexpr double kScanMatcherArm =
    3000;  // mm: typical distance of walls, converts a rotation to a distance

Information matrix_of(const Covariance& c) {
  Information matrix;
  matrix << c.xx, c.xy, c.x_rho, c.xy, c.yy, c.y_rho, c.x_rho, c.y_rho, c.rho_rho;
  return matrix;
}

Covariance covariance_of(const Information& m) {
  return {.xx = m(0, 0),
          .xy = m(0, 1),
          .yy = m(1, 1),
          .x_rho = m(0, 2),
          .y_rho = m(1, 2),
          .rho_rho = m(2, 2)};
}

}  // namespace

ScanMatcher::ScanMatcher() { points_.reserve(2 * kPoints); }

std::optional<Estimate> ScanMatcher::refined(const WallLines& walls, std::span<const BeamEnd> scan,
                                             const Estimate& estimate) {
  Information spread = matrix_of(estimate.covariance);
  spread.diagonal() +=
      Eigen::Vector3d(kSpreadDistance * kSpreadDistance, kSpreadDistance * kSpreadDistance,
                      kSpreadTurn * kSpreadTurn);
  const Information known = spread.inverse();
  if (!known.allFinite()) return std::nullopt;
  points_of(scan, {}, (scan.size() + kPoints / 2) / kPoints, points_);
  const double wide =
      std::sqrt(std::max(spread(0, 0), spread(1, 1))) + kScanMatcherArm * std::sqrt(spread(2, 2));
  const MatchSettings settings{
      .reach = std::clamp(2 * wide, kReachLeast, WallLines::kReach),
      .least_information = kLeastInformation,
      .measures_noise = true,
      .least_distance = std::hypot(kLeastDistance, walls.error()),
      .least_turn = std::hypot(kLeastTurn, walls.error() / kScanMatcherArm)};
  const auto found = match(walls, points_, estimate.pose, {estimate.pose, known}, settings);
  if (!found || found->share < kShareLeast || found->misfit > kMisfitMost) return std::nullopt;
  const Eigen::Vector3d moved(found->pose.x - estimate.pose.x, found->pose.y - estimate.pose.y,
                              signed_angle(found->pose.rho - estimate.pose.rho));
  if (!(moved.dot(known * moved) <= kScanMatcherFarthest)) return std::nullopt;
  const Information both = (known + found->information).inverse();
  if (!both.allFinite() || !(both.diagonal().minCoeff() > 0)) return std::nullopt;
  return Estimate{.pose = found->pose, .covariance = covariance_of(both), .share = estimate.share};
}

}  // namespace rack::localisation
