#include "components/mapping/calibration.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>

namespace rack::mapping {

namespace {

constexpr std::size_t kStepsLeast = 100;
constexpr double kStepMost = 1000;                    // mm: a gap in the log
constexpr double kKnownDistance = 1 / (20.0 * 20.0);  // 1/mm2: scans determine the step
constexpr double kKnownTurn = 1 / (0.006 * 0.006);    // 1/rad2
constexpr int kCalibrationRounds = 10;
constexpr double kScaleMost = 0.15;
constexpr double kAsideMost = 0.06;
constexpr double kTurnScaleMost = 0.2;
constexpr double kDriftMost = radians(5) / 1000;

struct Step {
  Pose odometry;
  Pose scans;
  bool knows_distance;
};

std::vector<Step> steps_of(const Track& track) {
  std::vector<Step> steps;
  // The edge by scans comes before that by odometry.
  for (std::size_t i = 0; i + 1 < track.edges.size(); ++i) {
    const Edge& scans = track.edges[i];
    const Edge& odometry = track.edges[i + 1];
    if (scans.from != odometry.from || scans.to != odometry.to) continue;
    if (track.keyframes[scans.to].placed != Placed::kByScans) continue;
    if (std::hypot(odometry.step.x, odometry.step.y) > kStepMost) continue;
    if (scans.information(2, 2) < kKnownTurn) continue;
    const Eigen::Matrix2d known = scans.information.topLeftCorner<2, 2>();
    const double weakest =
        known.trace() / 2 - std::hypot((known(0, 0) - known(1, 1)) / 2, known(0, 1));
    steps.push_back({odometry.step, scans.step, weakest > kKnownDistance});
  }
  return steps;
}

// y = a x1 + b x2 by least squares; rows with large residuals count less from round to round.
class Regression {
 public:
  void add(double x1, double x2, double y) { rows_.push_back({x1, x2, y}); }
  [[nodiscard]] std::size_t rows() const { return rows_.size(); }

  [[nodiscard]] Eigen::Vector2d solve(double ridge1, double ridge2) const {
    Eigen::Vector2d found = Eigen::Vector2d::Zero();
    double cut = 1e12;
    for (int round = 0; round < kCalibrationRounds; ++round) {
      Eigen::Matrix2d h = Eigen::Vector2d(ridge1, ridge2).asDiagonal();
      Eigen::Vector2d b = Eigen::Vector2d::Zero();
      std::vector<double> residuals;
      for (const Row& row : rows_) {
        const Eigen::Vector2d x(row.x1, row.x2);
        const double off = row.y - x.dot(found);
        residuals.push_back(std::abs(off));
        const double weight = 1 / (1 + (off / cut) * (off / cut));
        h += weight * x * x.transpose();
        b += weight * row.y * x;
      }
      found = h.inverse() * b;
      std::ranges::nth_element(
          residuals, residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2));
      cut = std::max(1e-9, 2 * residuals[residuals.size() / 2]);
    }
    return found;
  }

 private:
  struct Row {
    double x1;
    double x2;
    double y;
  };
  std::vector<Row> rows_;
};

}  // namespace

Pose Calibration::corrected(const Pose& step) const {
  const double turn = signed_angle(step.rho);
  return {.x = scale * step.x - aside * step.y,
          .y = scale * step.y + aside * step.x,
          .rho = turn_scale * turn + drift * step.x};
}

Calibration calibrate(const Track& track) {
  Regression along;
  Regression aside;
  Regression turn;
  for (const Step& step : steps_of(track)) {
    if (step.knows_distance && std::abs(signed_angle(step.odometry.rho)) < 0.1) {
      along.add(step.odometry.x, 0, step.scans.x - step.odometry.x);
      aside.add(step.odometry.x, 0, step.scans.y - step.odometry.y);
    }
    // By the turn of the scans: least squares attribute all noise to y, and the odometry has much.
    turn.add(step.odometry.x, signed_angle(step.scans.rho),
             signed_angle(step.odometry.rho - step.scans.rho));
  }
  Calibration found;
  if (along.rows() >= kStepsLeast) {
    found.scale += along.solve(1, 1)[0];
    found.aside = aside.solve(1, 1)[0];
  }
  if (turn.rows() >= kStepsLeast) {
    const Eigen::Vector2d turned = turn.solve(1, 1e-3);
    found.turn_scale = 1 / (1 + turned[1]);
    found.drift = -turned[0] * found.turn_scale;
  }
  const bool is_possible =
      std::abs(found.scale - 1) < kScaleMost && std::abs(found.aside) < kAsideMost &&
      std::abs(found.turn_scale - 1) < kTurnScaleMost && std::abs(found.drift) < kDriftMost;
  return is_possible ? found : Calibration{};
}

Drive corrected(Drive drive, const Calibration& calibration) {
  Pose before{};  // as recorded
  Pose now{};
  bool has_before = false;
  for (DriveScan& scan : drive.scans) {
    const Pose recorded = scan.odometry;
    if (!std::isfinite(recorded.x) || !std::isfinite(recorded.y) || !std::isfinite(recorded.rho))
      continue;
    now = has_before ? now + calibration.corrected(recorded - before) : recorded;
    before = recorded;
    has_before = true;
    scan.odometry = now;
  }
  return drive;
}

}  // namespace rack::mapping
