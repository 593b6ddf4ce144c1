#include "components/mapping/pose_graph.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "components/geometry/random.h"

namespace rack::mapping {

namespace {

using Vector = Eigen::Vector3d;
using Matrix = Eigen::Matrix3d;

constexpr double kOdd = 9;  // squared error from which an edge counts less: 3 standard deviations
constexpr double kOddAtFirst = 1e6;
constexpr double kOddFalls = 0.1;  // factor per round
constexpr int kRounds = 15;
constexpr double kDoneDistance = 0.1;  // mm
constexpr double kDoneTurn = 1e-5;     // rad
constexpr double kFixed = 1e6;         // information of the first pose
constexpr double kLeastPivot = 1e-12;
constexpr int kSpreadDraws = 16;

Vector error_of(const Edge& edge, std::span<const Pose> poses) {
  const Pose is = poses[edge.to] - poses[edge.from];
  return {is.x - edge.step.x, is.y - edge.step.y, signed_angle(is.rho - edge.step.rho)};
}

// The derivatives of the error by both poses.
struct Slopes {
  Matrix from;
  Matrix to;
};

Slopes slopes_of(const Edge& edge, std::span<const Pose> poses) {
  const Pose& from = poses[edge.from];
  const Pose& to = poses[edge.to];
  const double c = std::cos(from.rho);
  const double s = std::sin(from.rho);
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  Slopes slopes;
  slopes.to << c, s, 0, -s, c, 0, 0, 0, 1;
  slopes.from << -c, -s, -s * dx + c * dy, s, -c, -c * dx - s * dy, 0, 0, -1;
  return slopes;
}

class System {
 public:
  explicit System(std::size_t poses)
      : size_(static_cast<Eigen::Index>(3 * poses)), matrix_(size_, size_), right_(size_) {}

  bool solve(std::span<const Edge> edges, std::span<const Pose> poses, double odd,
             Eigen::VectorXd& step) {
    if (!factorise(edges, poses, odd)) return false;
    step = solver_.solve(right_);
    return solver_.info() == Eigen::Success && step.allFinite();
  }
  bool factorise(std::span<const Edge> edges, std::span<const Pose> poses, double odd) {
    entries_.clear();
    right_.setZero();
    for (const Edge& edge : edges) add(edge, poses, odd);
    for (Eigen::Index i = 0; i < 3; ++i) entries_.emplace_back(i, i, kFixed);
    matrix_.setFromTriplets(entries_.begin(), entries_.end());
    if (!analysed_) solver_.analyzePattern(matrix_);
    analysed_ = true;
    solver_.factorize(matrix_);
    return solver_.info() == Eigen::Success;
  }
  // A random step with the covariance of the solution: of A = L D L', the step L'^-1 D^-1/2 n has
  // the covariance A^-1.
  Eigen::VectorXd draw(Random& random) const {
    Eigen::VectorXd normal(size_);
    for (Eigen::Index i = 0; i < size_; ++i)
      normal[i] = static_cast<double>(random.normal()) /
                  std::sqrt(std::max(solver_.vectorD()[i], kLeastPivot));
    return solver_.permutationPinv() * solver_.matrixU().solve(normal);
  }

 private:
  void add(const Edge& edge, std::span<const Pose> poses, double odd) {
    const Vector error = error_of(edge, poses);
    const double square = error.dot(edge.information * error);
    const double weight = 1 / (1 + square / odd);
    const Slopes slopes = slopes_of(edge, poses);
    const Matrix w = weight * edge.information;
    const auto i = static_cast<Eigen::Index>(3 * edge.from);
    const auto j = static_cast<Eigen::Index>(3 * edge.to);
    block(i, i, slopes.from.transpose() * w * slopes.from);
    block(j, j, slopes.to.transpose() * w * slopes.to);
    if (i > j) {
      block(i, j, slopes.from.transpose() * w * slopes.to);
    } else {
      block(j, i, slopes.to.transpose() * w * slopes.from);
    }
    right_.segment<3>(i) -= slopes.from.transpose() * w * error;
    right_.segment<3>(j) -= slopes.to.transpose() * w * error;
  }
  // Only the lower triangle.
  void block(Eigen::Index row, Eigen::Index column, const Matrix& m) {
    for (Eigen::Index r = 0; r < 3; ++r)
      for (Eigen::Index c = 0; c < 3; ++c)
        if (row + r >= column + c) entries_.emplace_back(row + r, column + c, m(r, c));
  }

  Eigen::Index size_;
  Eigen::SparseMatrix<double> matrix_;
  Eigen::VectorXd right_;
  std::vector<Eigen::Triplet<double>> entries_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver_;
  bool analysed_ = false;
};

// Removes the rigid motion of all poses that explains most of the step (least squares), since the
// frame of a map is arbitrary, and adds the square of what is left to `squares`.
void add_shape(std::span<const Pose> poses, const Eigen::VectorXd& step,
               std::vector<double>& squares) {
  Matrix normal = Matrix::Zero();
  Vector right = Vector::Zero();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    const Vector x(1, 0, -poses[i].y);
    const Vector y(0, 1, poses[i].x);
    normal += x * x.transpose() + y * y.transpose();
    right += x * step[at] + y * step[at + 1];
  }
  const Vector motion = normal.ldlt().solve(right);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    const double x = step[at] - motion[0] + motion[2] * poses[i].y;
    const double y = step[at + 1] - motion[1] - motion[2] * poses[i].x;
    squares[i] += x * x + y * y;
  }
}

}  // namespace

std::vector<double> spread(std::span<const Edge> edges, std::span<const Pose> poses) {
  System equations(poses.size());
  if (poses.size() < 2 || !equations.factorise(edges, poses, kOdd)) return {};
  std::vector<double> deviations(poses.size());
  Random random(1);
  for (int i = 0; i < kSpreadDraws; ++i) add_shape(poses, equations.draw(random), deviations);
  for (double& square : deviations) square = std::sqrt(square / kSpreadDraws);
  return deviations;
}

double disagreement(const Edge& edge, std::span<const Pose> poses) {
  const Vector error = error_of(edge, poses);
  return error.dot(edge.information * error);
}

bool optimise(std::span<const Edge> edges, std::vector<Pose>& poses, Doubt doubt) {
  if (poses.size() < 2 || edges.empty()) return true;
  const std::vector<Pose> before = poses;
  System equations(poses.size());
  Eigen::VectorXd step;
  double odd = doubt == Doubt::kAlways ? kOdd : kOddAtFirst;
  for (int round = 0; round < kRounds; ++round) {
    if (!equations.solve(edges, poses, odd, step)) {
      poses = before;
      return false;
    }
    double distance = 0;
    double turn = 0;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const auto part = step.segment<3>(static_cast<Eigen::Index>(3 * i));
      poses[i].x += part[0];
      poses[i].y += part[1];
      poses[i].rho = heading(poses[i].rho + part[2]);
      distance = std::max({distance, std::abs(part[0]), std::abs(part[1])});
      turn = std::max(turn, std::abs(part[2]));
    }
    if (odd == kOdd && distance < kDoneDistance && turn < kDoneTurn) break;
    odd = std::max(kOdd, kOddFalls * odd);
  }
  return true;
}

}  // namespace rack::mapping
