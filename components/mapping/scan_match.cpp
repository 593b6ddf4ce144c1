#include "components/mapping/scan_match.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace rack::mapping {

namespace {

// --- points and their walls
constexpr float kApart = 40;               // mm: nearer ones say the same
constexpr std::ptrdiff_t kNeighbours = 4;  // on each side, that a wall is seen by
constexpr double kNeighbourWay = 400;      // mm
constexpr double kWallDeviationMax = 30;   // mm
constexpr double kWallLengthLeast = 60;    // mm
constexpr std::int64_t kCellsMax = 4'000'000;

// --- matching
constexpr int kRounds = 20;
constexpr float kSameWall = 0.7F;     // cosine of what their directions differ
constexpr double kDoneWay = 0.2;      // mm
constexpr double kDoneTurn = 0.0001;  // rad
constexpr std::size_t kPointsLeast = 12;
// A point errs by 20 mm; but neighbours err together, so that a fifth of them counts.
constexpr double kPointInformation = 1 / (20.0 * 20.0) / 5;
// However many points, a match errs by a cell of nothing: scanners are bent, robots sway.
constexpr double kLeastWay = 6;               // mm
constexpr double kLeastTurn = radians(0.12);  // rad

struct Wall {
  double nx = 0;
  double ny = 0;
};

// The line through the neighbours of a point: the small axis of their scatter.
Wall wall_at(std::span<const BeamEnd> scan, std::size_t at, const Pose& scanner) {
  const auto first = static_cast<std::ptrdiff_t>(at);
  const auto last = static_cast<std::ptrdiff_t>(scan.size()) - 1;
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  const auto ox = static_cast<double>(scan[at].x);
  const auto oy = static_cast<double>(scan[at].y);
  for (auto i = std::max<std::ptrdiff_t>(0, first - kNeighbours);
       i <= std::min(last, first + kNeighbours); ++i) {
    const double dx = static_cast<double>(scan[static_cast<std::size_t>(i)].x) - ox;
    const double dy = static_cast<double>(scan[static_cast<std::size_t>(i)].y) - oy;
    if (dx * dx + dy * dy > kNeighbourWay * kNeighbourWay) continue;
    n += 1;
    x += dx;
    y += dy;
    xx += dx * dx;
    xy += dx * dy;
    yy += dy * dy;
  }
  if (n < 3) return {};
  xx = xx / n - x * x / (n * n);
  xy = xy / n - x * y / (n * n);
  yy = yy / n - y * y / (n * n);
  const double middle = (xx + yy) / 2;
  const double apart = std::hypot((xx - yy) / 2, xy);
  if (middle - apart > kWallDeviationMax * kWallDeviationMax) return {};
  if (middle + apart < kWallLengthLeast * kWallLengthLeast || apart < middle / 2) return {};
  const double along = std::atan2(2 * xy, xx - yy) / 2;
  Wall wall{-std::sin(along), std::cos(along)};
  if (wall.nx * (scanner.x - ox) + wall.ny * (scanner.y - oy) < 0) wall = {-wall.nx, -wall.ny};
  return wall;
}

}  // namespace

std::vector<ScanPoint2d> points_of(std::span<const BeamEnd> scan, const Pose& scanner) {
  std::vector<ScanPoint2d> points;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (!points.empty() &&
        std::hypot(scan[i].x - points.back().x, scan[i].y - points.back().y) < kApart)
      continue;
    const Wall wall = wall_at(scan, i, scanner);
    points.push_back(
        {scan[i].x, scan[i].y, static_cast<float>(wall.nx), static_cast<float>(wall.ny)});
  }
  return points;
}

void add_points(std::span<const ScanPoint2d> points, const Pose& frame,
                std::vector<ScanPoint2d>& to) {
  const auto c = static_cast<float>(std::cos(frame.rho));
  const auto s = static_cast<float>(std::sin(frame.rho));
  const auto x = static_cast<float>(frame.x);
  const auto y = static_cast<float>(frame.y);
  for (const ScanPoint2d& p : points)
    to.push_back(
        {x + c * p.x - s * p.y, y + s * p.x + c * p.y, c * p.nx - s * p.ny, s * p.nx + c * p.ny});
}

// Sorted by cells: counted first, then put in their places. Points on no wall are left out.
PointIndex::PointIndex(std::span<const ScanPoint2d> points) {
  float high_x = -1e9F;
  float high_y = -1e9F;
  low_x_ = low_y_ = 1e9F;
  for (const ScanPoint2d& p : points) {
    if (!p.on_wall()) continue;
    low_x_ = std::min(low_x_, p.x);
    low_y_ = std::min(low_y_, p.y);
    high_x = std::max(high_x, p.x);
    high_y = std::max(high_y, p.y);
  }
  if (high_x < low_x_) return;
  const double rows = std::floor(static_cast<double>(high_x - low_x_) / kReach) + 3;
  const double columns = std::floor(static_cast<double>(high_y - low_y_) / kReach) + 3;
  if (!(rows * columns < kCellsMax)) return;
  low_x_ -= kReach;  // a row around, so that each cell has neighbours
  low_y_ -= kReach;
  rows_ = static_cast<std::int32_t>(rows);
  columns_ = static_cast<std::int32_t>(columns);
  begin_.resize(static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_) + 1);
  std::size_t count = 0;
  for (const ScanPoint2d& p : points) {
    if (!p.on_wall()) continue;
    ++begin_[cell(p.x, p.y) + 1];
    ++count;
  }
  for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  points_.resize(count);
  for (const ScanPoint2d& p : points)
    if (p.on_wall()) points_[next[cell(p.x, p.y)]++] = p;
}

std::size_t PointIndex::cell(float x, float y) const {
  const auto row = static_cast<std::size_t>((x - low_x_) / kReach);
  const auto column = static_cast<std::size_t>((y - low_y_) / kReach);
  return row * static_cast<std::size_t>(columns_) + column;
}

const ScanPoint2d* PointIndex::nearest(const ScanPoint2d& point, float reach) const {
  const float row = (point.x - low_x_) / kReach;
  const float column = (point.y - low_y_) / kReach;
  // Also false for what is no number.
  const bool is_inside = row >= 1 && column >= 1 && row < static_cast<float>(rows_ - 1) &&
                         column < static_cast<float>(columns_ - 1);
  if (!is_inside) return nullptr;
  const auto middle = static_cast<std::ptrdiff_t>(cell(point.x, point.y));
  float least = reach * reach;
  const ScanPoint2d* best = nullptr;
  for (std::ptrdiff_t r = -columns_; r <= columns_; r += columns_) {
    // Three cells of a row lie side by side.
    const std::uint32_t end = begin_[static_cast<std::size_t>(middle + r + 2)];
    for (std::uint32_t i = begin_[static_cast<std::size_t>(middle + r - 1)]; i < end; ++i) {
      const ScanPoint2d& other = points_[i];
      const float dx = other.x - point.x;
      const float dy = other.y - point.y;
      const float square = dx * dx + dy * dy;
      if (square >= least) continue;
      if (other.nx * point.nx + other.ny * point.ny < kSameWall) continue;
      least = square;
      best = &other;
    }
  }
  return best;
}

namespace {

struct Sums {
  Information h{Information::Zero()};
  Eigen::Vector3d b{Eigen::Vector3d::Zero()};
  double squares = 0;
  std::size_t found = 0;
  std::size_t all = 0;
};

// One look at all points from this pose.
Sums sums_at(const PointIndex& others, std::span<const ScanPoint2d> scan, const Pose& pose,
             double reach, double cut) {
  const double c = std::cos(pose.rho);
  const double s = std::sin(pose.rho);
  Sums sums;
  for (const ScanPoint2d& p : scan) {
    if (!p.on_wall()) continue;
    ++sums.all;
    const auto px = static_cast<double>(p.x);
    const auto py = static_cast<double>(p.y);
    const double rx = c * px - s * py;
    const double ry = s * px + c * py;
    const ScanPoint2d seen{static_cast<float>(pose.x + rx), static_cast<float>(pose.y + ry),
                           static_cast<float>(c) * p.nx - static_cast<float>(s) * p.ny,
                           static_cast<float>(s) * p.nx + static_cast<float>(c) * p.ny};
    const ScanPoint2d* other = others.nearest(seen, static_cast<float>(reach));
    if (other == nullptr) continue;
    const auto nx = static_cast<double>(other->nx);
    const auto ny = static_cast<double>(other->ny);
    const double off = nx * (pose.x + rx - static_cast<double>(other->x)) +
                       ny * (pose.y + ry - static_cast<double>(other->y));
    const double part = off / cut;
    if (std::abs(part) >= 1) continue;
    ++sums.found;
    sums.squares += off * off;
    const double weight = (1 - part * part) * (1 - part * part) * kPointInformation;
    const Eigen::Vector3d j(nx, ny, -nx * ry + ny * rx);
    sums.h += weight * j * j.transpose();
    sums.b -= weight * off * j;
  }
  return sums;
}

// A match is never surer than its least error.
Information limited(const Information& h) {
  Information least = Information::Zero();
  least.diagonal() << kLeastWay * kLeastWay, kLeastWay * kLeastWay, kLeastTurn * kLeastTurn;
  // (H^-1 + L)^-1 = (1 + H L)^-1 H: also of an H that has no inverse.
  const Information all = (Information::Identity() + h * least).inverse() * h;
  return (all + all.transpose()) / 2;
}

// The prior pulls at the pose in the frame of the others, as the points do.
void add_prior(const Prior& prior, const Pose& pose, Sums& sums) {
  const Eigen::Vector3d off(pose.x - prior.pose.x, pose.y - prior.pose.y,
                            signed_angle(pose.rho - prior.pose.rho));
  sums.h += prior.information;
  sums.b -= prior.information * off;
}

}  // namespace

std::optional<Match> match(const PointIndex& others, std::span<const ScanPoint2d> scan,
                           const Pose& start, const Prior& prior) {
  if (others.empty()) return std::nullopt;
  Pose pose = start;
  double reach = PointIndex::kReach;
  for (int round = 0; round < kRounds; ++round) {
    // Farther points first: they are what turns it the right way.
    reach = std::max(100.0, reach * 0.8);
    Sums sums = sums_at(others, scan, pose, reach, reach);
    if (sums.found < kPointsLeast) return std::nullopt;
    add_prior(prior, pose, sums);
    // What nobody knows anything of stays as it is.
    sums.h.diagonal() += Eigen::Vector3d(1e-9, 1e-9, 1e-3);
    const Eigen::Vector3d step = sums.h.ldlt().solve(sums.b);
    if (!step.allFinite()) return std::nullopt;
    pose.x += step[0];
    pose.y += step[1];
    pose.rho = heading(pose.rho + step[2]);
    if (reach <= 100 && std::hypot(step[0], step[1]) < kDoneWay && std::abs(step[2]) < kDoneTurn)
      break;
  }
  const Sums sums = sums_at(others, scan, pose, 150, 100);
  if (sums.found < kPointsLeast) return std::nullopt;
  return Match{.pose = pose,
               .information = limited(sums.h),
               .share = static_cast<double>(sums.found) / static_cast<double>(sums.all),
               .misfit = std::sqrt(sums.squares / static_cast<double>(sums.found)),
               .points = sums.found};
}

}  // namespace rack::mapping
