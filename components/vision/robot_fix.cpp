#include "components/vision/robot_fix.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Dense>

namespace rack::vision {

using scan3d::Place;

namespace {

constexpr double kAgrees = 4;        // pixels, root mean square of the corners of a marker
constexpr double kPixelNoise = 0.3;  // pixels, of a corner at least
constexpr int kStepsMax = 20;
// Errors of the map and of the lens, which more pixels do not reduce.
constexpr double kMapDeviation = 10;         // mm
constexpr double kScaleDeviation = 0.01;     // of the distance
constexpr double kHeadingDeviation = 0.005;  // rad
// Poses that are this far apart are different ones.
constexpr double kApart = 200;  // mm
constexpr double kApartRho = radians(8);
// A second pose counts if its error is less than this multiple of the first one's.
constexpr double kNearlyAsGood = 1.5;

using Corners = std::array<Place, 4>;

// In the frame of the map, with z down.
Corners corners_of(const Marker& marker) {
  const double half = marker.size / 2;
  // To the right of somebody who looks at its face.
  const double right_x = std::sin(marker.rho) * half;
  const double right_y = -std::cos(marker.rho) * half;
  const auto corner = [&](double right, double up) {
    return Place{marker.at.x + right * right_x, marker.at.y + right * right_y,
                 -(marker.height + up * half)};
  };
  return {corner(-1, 1), corner(1, 1), corner(1, -1), corner(-1, -1)};
}

Place to_robot(const Place& in_map, const Pose& robot) {
  const double c = std::cos(robot.rho);
  const double s = std::sin(robot.rho);
  const double x = in_map.x - robot.x;
  const double y = in_map.y - robot.y;
  return {c * x + s * y, c * y - s * x, in_map.z};
}

Pose robot_of(const Marker& marker, const MarkerPose& seen) {
  Pose robot{.rho = heading(marker.rho - seen.rho)};
  const double c = std::cos(robot.rho);
  const double s = std::sin(robot.rho);
  robot.x = marker.at.x - (c * seen.at.x - s * seen.at.y);
  robot.y = marker.at.y - (s * seen.at.x + c * seen.at.y);
  return robot;
}

class Fit {
 public:
  explicit Fit(const CameraGeometry& camera) : camera_(camera) {}

  // Mean square error of the corners, pixels squared; empty: one is behind the lens.
  [[nodiscard]] std::optional<double> error(const Landmark& landmark, const Pose& robot) const {
    const Corners corners = corners_of(landmark.marker);
    double sum = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const auto pixel = camera_.pixel(to_robot(corners.at(i), robot));
      if (!pixel) return std::nullopt;
      sum += square(pixel->column - landmark.corners.at(i).column) +
             square(pixel->row - landmark.corners.at(i).row);
    }
    return sum / corners.size();
  }

  [[nodiscard]] bool agrees(const Landmark& landmark, const Pose& robot) const {
    const auto found = error(landmark, robot);
    return found && *found <= kAgrees * kAgrees;
  }

  // Gauss-Newton from `start`; empty when it leaves what the camera can see.
  [[nodiscard]] std::optional<RobotFix> refined(std::span<const Landmark* const> landmarks,
                                                const Pose& start) const {
    Pose robot = start;
    Normal normal;
    for (int i = 0; i < kStepsMax; ++i) {
      const auto made = normal_at(landmarks, robot);
      if (!made) return std::nullopt;
      normal = *made;
      const Eigen::Vector3d step = normal.matrix.ldlt().solve(normal.vector);
      if (!step.allFinite()) return std::nullopt;
      robot.x += step[0];
      robot.y += step[1];
      robot.rho = heading(robot.rho + step[2]);
      if (std::hypot(step[0], step[1]) < 0.1 && std::abs(step[2]) < 1e-5) break;
    }
    return fix(landmarks, robot, normal);
  }

 private:
  struct Normal {
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
    Eigen::Vector3d vector = Eigen::Vector3d::Zero();
    double squares = 0;
    int count = 0;
  };

  static double square(double value) { return value * value; }

  [[nodiscard]] std::optional<Normal> normal_at(std::span<const Landmark* const> landmarks,
                                                const Pose& robot) const {
    Normal normal;
    for (const Landmark* landmark : landmarks) {
      const Corners corners = corners_of(landmark->marker);
      for (std::size_t i = 0; i < corners.size(); ++i)
        if (!add(normal, corners.at(i), landmark->corners.at(i), robot)) return std::nullopt;
    }
    return normal;
  }

  // One corner, with its derivatives by small differences.
  bool add(Normal& normal, const Place& corner, const ImagePoint& seen, const Pose& robot) const {
    constexpr double kStep = 1;     // mm
    constexpr double kTurn = 1e-4;  // rad
    const auto here = camera_.pixel(to_robot(corner, robot));
    const auto by_x =
        camera_.pixel(to_robot(corner, {.x = robot.x + kStep, .y = robot.y, .rho = robot.rho}));
    const auto by_y =
        camera_.pixel(to_robot(corner, {.x = robot.x, .y = robot.y + kStep, .rho = robot.rho}));
    const auto by_rho =
        camera_.pixel(to_robot(corner, {.x = robot.x, .y = robot.y, .rho = robot.rho + kTurn}));
    if (!here || !by_x || !by_y || !by_rho) return false;
    const auto take = [&](double at, double dx, double dy, double drho, double wanted) {
      const Eigen::Vector3d slope((dx - at) / kStep, (dy - at) / kStep, (drho - at) / kTurn);
      const double missing = wanted - at;
      normal.matrix += slope * slope.transpose();
      normal.vector += slope * missing;
      normal.squares += square(missing);
      ++normal.count;
    };
    take(here->column, by_x->column, by_y->column, by_rho->column, seen.column);
    take(here->row, by_x->row, by_y->row, by_rho->row, seen.row);
    return true;
  }

  [[nodiscard]] std::optional<RobotFix> fix(std::span<const Landmark* const> landmarks,
                                            const Pose& robot, const Normal& normal) const {
    const double error = std::sqrt(2 * normal.squares / normal.count);
    const Eigen::Matrix3d covariance =
        normal.matrix.inverse() * square(std::max(error / std::numbers::sqrt2, kPixelNoise));
    if (!covariance.allFinite()) return std::nullopt;
    double nearest = distance(landmarks.front()->marker.at, {robot.x, robot.y});
    for (const Landmark* landmark : landmarks)
      nearest = std::min(nearest, distance(landmark->marker.at, {robot.x, robot.y}));
    return RobotFix{
        .pose = robot,
        .deviation = std::sqrt(std::max(covariance(0, 0), covariance(1, 1)) +
                               square(kMapDeviation) + square(kScaleDeviation * nearest)),
        .deviation_rho = std::sqrt(covariance(2, 2) + square(kHeadingDeviation)),
        .error = error,
        .markers = landmarks.size()};
  }

  const CameraGeometry& camera_;
};

bool is_apart(const Pose& a, const Pose& b) {
  return std::hypot(a.x - b.x, a.y - b.y) > kApart ||
         std::abs(signed_angle(a.rho - b.rho)) > kApartRho;
}

// Refined by one marker, then by all that agree.
std::optional<RobotFix> fix_from(const Landmark& first, const MarkerPose& seen,
                                 std::span<const Landmark> all, const Fit& fit) {
  const std::array alone{&first};
  const auto rough = fit.refined(alone, robot_of(first.marker, seen));
  if (!rough || !fit.agrees(first, rough->pose)) return std::nullopt;
  std::vector<const Landmark*> agreeing;
  for (const Landmark& landmark : all)
    if (fit.agrees(landmark, rough->pose)) agreeing.push_back(&landmark);
  return agreeing.size() == 1 ? rough : fit.refined(agreeing, rough->pose);
}

}  // namespace

std::vector<RobotFix> fixes_of(std::span<const Landmark> landmarks, const CameraGeometry& camera) {
  const Fit fit(camera);
  std::vector<RobotFix> fixes;
  for (const Landmark& landmark : landmarks)
    for (const MarkerPose& seen : landmark.poses)
      if (const auto fix = fix_from(landmark, seen, landmarks, fit)) fixes.push_back(*fix);
  std::ranges::sort(fixes, [](const RobotFix& a, const RobotFix& b) {
    return a.markers != b.markers ? a.markers > b.markers : a.error < b.error;
  });
  std::vector<RobotFix> different;
  for (const RobotFix& fix : fixes) {
    const bool is_as_good =
        different.empty() ||
        (fix.markers == different.front().markers &&
         fix.error <= kNearlyAsGood * std::max(different.front().error, kPixelNoise));
    const bool is_new = std::ranges::all_of(
        different, [&](const RobotFix& other) { return is_apart(fix.pose, other.pose); });
    if (is_as_good && is_new) different.push_back(fix);
  }
  return different;
}

}  // namespace rack::vision
