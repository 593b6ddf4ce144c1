#include "components/localisation/line_match.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "components/geometry/scatter.h"

namespace rack::localisation {

namespace {

// --- points and their walls
constexpr float kApart = 40;                        // mm, minimum distance of points
constexpr std::ptrdiff_t kLineMatchNeighbours = 4;  // on each side, for the direction of a wall
constexpr double kNeighbourDistance = 400;          // mm
constexpr double kWallDeviationMax = 30;            // mm
constexpr double kWallLengthLeast = 60;             // mm

// --- matching
constexpr int kRounds = 20;
constexpr double kReachLast = 100;     // mm
constexpr double kDoneDistance = 0.2;  // mm
constexpr double kDoneTurn = 0.0001;   // rad
constexpr std::size_t kPointsLeast = 12;
// The standard deviation of a point is 20 mm; errors of neighbours are correlated, so a point
// counts a fifth.
constexpr double kPointInformation = 1 / (20.0 * 20.0) / 5;
constexpr double kLineMatchArm = 1000;    // mm: lever arm that converts a rotation to a distance
constexpr std::size_t kTogether = 12;     // neighbours whose errors may be correlated
constexpr double kSameDirection = 0.9;    // cosine between normals of one wall
constexpr double kPointErrorLeast = 4.0;  // mm2

struct Wall {
  double nx = 0;
  double ny = 0;
};

// The line through the neighbours of a point: its normal is the minor axis of their scatter.
Wall wall_at(std::span<const BeamEnd> scan, std::size_t at, const Pose& scanner,
             std::ptrdiff_t every) {
  const auto middle_at = static_cast<std::ptrdiff_t>(at);
  const auto last = static_cast<std::ptrdiff_t>(scan.size()) - 1;
  Scatter wall_points;
  const auto ox = static_cast<double>(scan[at].x);
  const auto oy = static_cast<double>(scan[at].y);
  for (std::ptrdiff_t k = -kLineMatchNeighbours; k <= kLineMatchNeighbours; ++k) {
    const std::ptrdiff_t i = middle_at + k * every;
    if (i < 0 || i > last) continue;
    const double dx = static_cast<double>(scan[static_cast<std::size_t>(i)].x) - ox;
    const double dy = static_cast<double>(scan[static_cast<std::size_t>(i)].y) - oy;
    if (!(dx * dx + dy * dy <= kNeighbourDistance * kNeighbourDistance)) continue;
    wall_points.add(dx, dy);
  }
  if (wall_points.points() < 3) return {};
  const auto [lengthwise, beside] = wall_points.variances();
  if (beside > kWallDeviationMax * kWallDeviationMax) return {};
  if (lengthwise < kWallLengthLeast * kWallLengthLeast || lengthwise < 3 * beside) return {};
  const double along = wall_points.direction();
  Wall wall{-std::sin(along), std::cos(along)};
  if (wall.nx * (scanner.x - ox) + wall.ny * (scanner.y - oy) < 0) wall = {-wall.nx, -wall.ny};
  return wall;
}

}  // namespace

void points_of(std::span<const BeamEnd> scan, const Pose& scanner, std::size_t every,
               std::vector<ScanPoint2d>& points) {
  points.clear();
  every = std::max<std::size_t>(1, every);
  for (std::size_t i = 0; i < scan.size(); i += every) {
    if (!points.empty() &&
        std::hypot(scan[i].x - points.back().x, scan[i].y - points.back().y) < kApart)
      continue;
    const Wall wall = wall_at(scan, i, scanner, static_cast<std::ptrdiff_t>(every));
    points.push_back(
        {scan[i].x, scan[i].y, static_cast<float>(wall.nx), static_cast<float>(wall.ny)});
  }
}

namespace {

// The normal equations of one iteration over all points.
class Sums {
 public:
  Sums(const Lines& lines, std::span<const ScanPoint2d> scan, const Pose& pose, double reach,
       double cut)
      : cut_(cut) {
    const double c = std::cos(pose.rho);
    const double s = std::sin(pose.rho);
    for (const ScanPoint2d& p : scan) {
      if (!p.on_wall()) continue;
      ++all;
      const auto px = static_cast<double>(p.x);
      const auto py = static_cast<double>(p.y);
      const double rx = c * px - s * py;
      const double ry = s * px + c * py;
      const ScanPoint2d seen{static_cast<float>(pose.x + rx), static_cast<float>(pose.y + ry),
                             static_cast<float>(c) * p.nx - static_cast<float>(s) * p.ny,
                             static_cast<float>(s) * p.nx + static_cast<float>(c) * p.ny};
      const ScanPoint2d* line = lines.nearest(seen, static_cast<float>(reach));
      if (line == nullptr) continue;
      const auto nx = static_cast<double>(line->nx);
      const auto ny = static_cast<double>(line->ny);
      const double off = nx * (pose.x + rx - static_cast<double>(line->x)) +
                         ny * (pose.y + ry - static_cast<double>(line->y));
      add(off, {nx, ny, -nx * ry + ny * rx});
    }
    end_block();
  }

  // The factor between the actual information of a point and kPointInformation: from the variance
  // of a robust mean of the residuals (Huber 1981, section 6.3), times the ratio by which
  // neighbours together deviate more than independent errors would.
  [[nodiscard]] double measured() const {
    const auto n = static_cast<double>(found);
    const double alone = std::max(pulls_ / n, 1e-9);
    const double together = std::max(1.0, blocks_ / std::max(pulls_, 1e-9));
    const double slope = std::max(slopes_ / n, 0.1);
    const double variance = alone * together / (slope * slope) * n / (n - 3);
    return 1 / (weights_ / n * std::max(variance, kPointErrorLeast) * kPointInformation);
  }

  Information h{Information::Zero()};
  Eigen::Vector3d b{Eigen::Vector3d::Zero()};
  double squares = 0;
  std::size_t found = 0;
  std::size_t all = 0;

 private:
  void add(double off, const Eigen::Vector3d& j) {
    const double square = (off / cut_) * (off / cut_);
    if (!(square < 1)) return;
    ++found;
    squares += off * off;
    const double weight = (1 - square) * (1 - square);
    h += kPointInformation * weight * j * j.transpose();
    b -= kPointInformation * weight * off * j;
    const double pull = weight * off;
    if (in_block_ == kTogether || j[0] * nx_ + j[1] * ny_ < kSameDirection) end_block();
    block_ += pull;
    ++in_block_;
    nx_ = j[0];
    ny_ = j[1];
    pulls_ += pull * pull;
    weights_ += weight;
    slopes_ += (1 - square) * (1 - 5 * square);
  }
  void end_block() {
    blocks_ += block_ * block_;
    block_ = 0;
    in_block_ = 0;
  }

  double cut_;
  double nx_ = 0;  // normal of the last point's line
  double ny_ = 0;
  double block_ = 0;
  std::size_t in_block_ = 0;
  double blocks_ = 0;
  double pulls_ = 0;
  double weights_ = 0;
  double slopes_ = 0;
};

// Limits the information to that of the minimum error.
Information limited(const Information& h, const MatchSettings& settings) {
  Information least = Information::Zero();
  least.diagonal() << settings.least_distance * settings.least_distance,
      settings.least_distance * settings.least_distance, settings.least_turn * settings.least_turn;
  // (H^-1 + L)^-1 = (1 + H L)^-1 H, which is also defined for a singular H.
  const Information all = (Information::Identity() + h * least).inverse() * h;
  return (all + all.transpose()) / 2;
}

// Removes the information about directions that are determined by too few points.
void drop_weak_directions(Sums& sums, double least) {
  if (least <= 0) return;
  const Eigen::Vector3d scale(1, 1, 1 / kLineMatchArm);
  const Information h = scale.asDiagonal() * sums.h * scale.asDiagonal();
  Eigen::SelfAdjointEigenSolver<Information> axes;
  axes.computeDirect(h);
  Information kept = Information::Zero();
  for (Eigen::Index i = 0; i < 3; ++i)
    if (axes.eigenvalues()[i] >= least * kPointInformation)
      kept += axes.eigenvectors().col(i) * axes.eigenvectors().col(i).transpose();
  const Eigen::Vector3d back = scale.cwiseInverse();
  sums.h = back.asDiagonal() * (kept * h * kept) * back.asDiagonal();
  sums.b = back.asDiagonal() * (kept * (scale.asDiagonal() * sums.b));
}

// The prior is a measurement of the pose in the frame of the lines, as the points are.
void add_prior(const Prior& prior, const Pose& pose, Sums& sums) {
  const Eigen::Vector3d off(pose.x - prior.pose.x, pose.y - prior.pose.y,
                            signed_angle(pose.rho - prior.pose.rho));
  sums.h += prior.information;
  sums.b -= prior.information * off;
}

}  // namespace

std::optional<Match> match(const Lines& lines, std::span<const ScanPoint2d> scan, const Pose& start,
                           const Prior& prior, const MatchSettings& settings) {
  if (lines.empty()) return std::nullopt;
  Pose pose = start;
  double reach = settings.reach;
  for (int round = 0; round < kRounds; ++round) {
    // Distant points first: they determine the rotation.
    reach = std::max(kReachLast, reach * 0.8);
    Sums sums(lines, scan, pose, reach, reach);
    if (sums.found < kPointsLeast) return std::nullopt;
    drop_weak_directions(sums, settings.least_information);
    add_prior(prior, pose, sums);
    // Directions without any information keep their value.
    sums.h.diagonal() += Eigen::Vector3d(1e-9, 1e-9, 1e-3);
    const Eigen::Vector3d step = sums.h.ldlt().solve(sums.b);
    if (!step.allFinite()) return std::nullopt;
    pose.x += step[0];
    pose.y += step[1];
    pose.rho = heading(pose.rho + step[2]);
    if (reach <= kReachLast && std::hypot(step[0], step[1]) < kDoneDistance &&
        std::abs(step[2]) < kDoneTurn)
      break;
  }
  Sums sums(lines, scan, pose, 1.5 * kReachLast, kReachLast);
  if (sums.found < kPointsLeast) return std::nullopt;
  drop_weak_directions(sums, settings.least_information);
  if (settings.measures_noise) sums.h *= sums.measured();
  return Match{.pose = pose,
               .information = limited(sums.h, settings),
               .share = static_cast<double>(sums.found) / static_cast<double>(sums.all),
               .misfit = std::sqrt(sums.squares / static_cast<double>(sums.found)),
               .points = sums.found};
}

}  // namespace rack::localisation
