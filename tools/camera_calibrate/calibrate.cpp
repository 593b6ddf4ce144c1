#include "tools/camera_calibrate/calibrate.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/core.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "components/pictures/opencv_call.h"

namespace rack::camera_calibrate {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;

constexpr double kTiltsMin = 10;          // degrees between two positions of the board
constexpr double kUncertaintyMax = 0.05;  // of a focal length
constexpr double kUncertaintyUsual = 0.01;
constexpr double kErrorMax = 10;     // pixels
constexpr double kErrorUsual = 1;    // pixels
constexpr double kOutlier = 2;       // times the median of all views
constexpr double kOutlierMin = 0.3;  // pixels
constexpr std::size_t kViewsUsual = 15;

Error not_determined(std::string what) { return {Errc::kInvalidArgument, std::move(what)}; }

struct Solution {
  cv::Mat camera;
  cv::Mat distortion;
  cv::Mat deviations;
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> shifts;
  double error = 0;
};

std::vector<cv::Point3f> points_of(const Board& board) {
  std::vector<cv::Point3f> points;
  for (const BoardPosition& position : positions(board))
    points.emplace_back(static_cast<float>(position.x), static_cast<float>(position.y), 0.0F);
  return points;
}

std::vector<cv::Point2f> points_of(const View& view) {
  std::vector<cv::Point2f> points;
  points.reserve(view.points.size());
  for (const PicturePoint& point : view.points) points.emplace_back(point.x, point.y);
  return points;
}

Result<Solution> solve(std::span<const View> views, const Board& board, cv::Size size,
                       const CalibrationSettings& settings) {
  const std::vector<std::vector<cv::Point3f>> on_board(views.size(), points_of(board));
  std::vector<std::vector<cv::Point2f>> seen;
  for (const View& view : views) seen.push_back(points_of(view));
  Solution solution;
  cv::Mat of_positions;
  cv::Mat of_views;
  auto done = pictures::call_opencv("calibrating", [&] {
    solution.error =
        cv::calibrateCamera(on_board, seen, size, solution.camera, solution.distortion,
                            solution.rotations, solution.shifts, solution.deviations, of_positions,
                            of_views, settings.has_k3 ? 0 : cv::CALIB_FIX_K3,
                            {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-9});
  });
  if (!done)
    return not_determined("these views do not determine the camera (" + done.error().detail() +
                          "): take 15 to 30 with the board tilted in different directions");
  return solution;
}

// The largest angle between two positions of the board, degrees.
double tilts_of(const std::vector<cv::Mat>& rotations) {
  std::vector<cv::Vec3d> normals;
  for (const cv::Mat& rotation : rotations) {
    cv::Matx33d matrix;
    cv::Rodrigues(rotation, matrix);
    normals.emplace_back(matrix(0, 2), matrix(1, 2), matrix(2, 2));
  }
  double least = 1;
  for (const cv::Vec3d& a : normals)
    for (const cv::Vec3d& b : normals) least = std::min(least, a.dot(b));
  return std::acos(std::clamp(least, -1.0, 1.0)) * 180 / std::numbers::pi;
}

Result<void> check_solution(const Calibrated& made, double tilts) {
  const pictures::CameraMatrix& camera = made.calibration.camera;
  const pictures::CameraMatrix& deviation = made.uncertainty;
  if (tilts < kTiltsMin)
    return not_determined(
        fmt::format("the board has the same direction in all views, within {:.0f} degrees: its "
                    "distance and the focal length cannot be separated. Tilt the board by 20 to 45 "
                    "degrees, in different directions",
                    std::max(std::ceil(tilts), 1.0)));
  if (made.error > kErrorMax)
    return not_determined(
        fmt::format("the residuals are {:.1f} pixels: are --board and --size those of this board, "
                    "is it flat, and "
                    "are all pictures of one camera, with the same zoom and focus?",
                    made.error));
  const bool is_finite = std::isfinite(made.error) && std::isfinite(camera.fx + camera.fy) &&
                         std::isfinite(deviation.fx + deviation.fy) && camera.fx >= 1 &&
                         camera.fy >= 1;
  if (!is_finite || std::max(deviation.fx / camera.fx, deviation.fy / camera.fy) > kUncertaintyMax)
    return not_determined(
        "these views do not determine the focal length: tilt the board by 20 to 45 degrees, in "
        "different directions, and bring it nearer");
  return {};
}

double median_of(const std::vector<CalibratedView>& views) {
  std::vector<double> errors;
  errors.reserve(views.size());
  for (const CalibratedView& view : views) errors.push_back(view.error);
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return *middle;
}

void mark_outliers(Calibrated& made) {
  const double median = median_of(made.views);
  for (CalibratedView& view : made.views) {
    view.is_outlier = view.error > std::max(kOutlier * median, kOutlierMin);
    if (view.is_outlier)
      made.warnings.push_back(fmt::format(
          "{}: {:.2f} pixels, {:.1f} times the median of all views: is it blurred, or the board "
          "bent? Calibrate without it",
          view.name, view.error, view.error / median));
  }
}

void add_warnings(Calibrated& made) {
  mark_outliers(made);
  const pictures::CameraMatrix& camera = made.calibration.camera;
  const double uncertain =
      std::max(made.uncertainty.fx / camera.fx, made.uncertainty.fy / camera.fy);
  if (made.views.size() < kViewsUsual)
    made.warnings.push_back(fmt::format("only {} views; 15 to 30 are better", made.views.size()));
  if (made.covered < kCoveredMin)
    made.warnings.push_back(
        fmt::format("the board was seen in {:.0f} % of the picture only: the distortion outside is "
                    "a guess. Add views at the edges and in the corners",
                    100 * made.covered));
  if (uncertain > kUncertaintyUsual)
    made.warnings.push_back(fmt::format(
        "the focal length is known to {:.1f} % only: add views with the board tilted by 20 to 45 "
        "degrees",
        100 * uncertain));
  if (made.error > kErrorUsual)
    made.warnings.push_back(fmt::format(
        "the residuals are {:.2f} pixels; below 0.5 is usual: is the board flat, and were "
        "the pictures sharp?",
        made.error));
}

CalibratedView view_of(const View& view, const std::vector<cv::Point3f>& board,
                       const Solution& solution, std::size_t index) {
  std::vector<cv::Point2f> expected;
  cv::projectPoints(board, solution.rotations.at(index), solution.shifts.at(index), solution.camera,
                    solution.distortion, expected);
  CalibratedView result{.name = view.name};
  double squares = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Residual residual{.at = view.points[i],
                            .x = static_cast<double>(view.points[i].x) - expected[i].x,
                            .y = static_cast<double>(view.points[i].y) - expected[i].y};
    squares += residual.x * residual.x + residual.y * residual.y;
    result.residuals.push_back(residual);
  }
  result.error = std::sqrt(squares / static_cast<double>(expected.size()));
  return result;
}

pictures::CameraMatrix matrix_of(const cv::Mat& camera) {
  return {.fx = camera.at<double>(0, 0),
          .fy = camera.at<double>(1, 1),
          .cx = camera.at<double>(0, 2),
          .cy = camera.at<double>(1, 2)};
}

Calibrated made_of(std::span<const View> views, const Board& board, cv::Size size,
                   const Solution& solution, const CalibrationSettings& settings) {
  Calibrated made{.error = solution.error};
  made.calibration.width = size.width;
  made.calibration.height = size.height;
  made.calibration.camera = matrix_of(solution.camera);
  const cv::Mat row = solution.distortion.reshape(1, 1);
  made.calibration.distortion.assign(row.ptr<double>(), row.ptr<double>() + 5);
  made.calibration.rectified = matrix_of(cv::getOptimalNewCameraMatrix(
      solution.camera, solution.distortion, size, settings.keep, size));
  made.uncertainty = {.fx = solution.deviations.at<double>(0),
                      .fy = solution.deviations.at<double>(1),
                      .cx = solution.deviations.at<double>(2),
                      .cy = solution.deviations.at<double>(3)};
  made.covered = covered_part(views, size.width, size.height);
  const auto on_board = points_of(board);
  for (std::size_t i = 0; i < views.size(); ++i)
    made.views.push_back(view_of(views[i], on_board, solution, i));
  return made;
}

}  // namespace

Result<Calibrated> calibrate(std::span<const View> views, const Board& board, int width, int height,
                             const CalibrationSettings& settings) {
  if (views.size() < kCalibrationViewsMin)
    return not_determined(fmt::format(
        "{} views of the board; at least {} are needed, 15 to 30 are better: with the board in all "
        "parts of the picture, tilted by 20 to 45 degrees in different directions",
        views.size(), kCalibrationViewsMin));
  if (views.size() > kCalibrationViewsMax)
    return not_determined(fmt::format("{} views; at most {} are possible, 15 to 30 are enough",
                                      views.size(), kCalibrationViewsMax));
  const cv::Size size(width, height);
  const auto solution = solve(views, board, size, settings);
  if (!solution) return solution.error();
  Calibrated made;
  double tilts = 0;
  auto done = pictures::call_opencv("evaluating the calibration", [&] {
    made = made_of(views, board, size, *solution, settings);
    tilts = tilts_of(solution->rotations);
  });
  if (!done) return done.error();
  if (auto good = check_solution(made, tilts); !good) return good.error();
  add_warnings(made);
  return made;
}

}  // namespace rack::camera_calibrate
