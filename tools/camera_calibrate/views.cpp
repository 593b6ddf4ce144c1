#include "tools/camera_calibrate/views.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/core.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "components/pictures/opencv_call.h"

namespace rack::camera_calibrate {
namespace {

constexpr double kStillMax = 0.004;      // mean movement between two pictures, part of the width
constexpr double kDifferenceMin = 0.15;  // sum of the differences of two shapes
constexpr double kNearMin = 0.3;
constexpr int kPointsInAreaMin = 6;
constexpr int kTiltedMin = 2;  // views

double distance(const PicturePoint& a, const PicturePoint& b) {
  return std::hypot(static_cast<double>(a.x) - b.x, static_cast<double>(a.y) - b.y);
}

// Points 0, 1, 2, 3 around the area (shoelace formula).
double area_of(const std::array<PicturePoint, 4>& corners) {
  double twice = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const PicturePoint& a = corners.at(i);
    const PicturePoint& b = corners.at((i + 1) % 4);
    twice += static_cast<double>(a.x) * b.y - static_cast<double>(b.x) * a.y;
  }
  return std::abs(twice) / 2;
}

// Corners in their order around the board, which may be turned: to upper left, upper right, lower
// right, lower left in the picture.
std::array<PicturePoint, 4> from_upper_left(std::array<PicturePoint, 4> corners) {
  std::ranges::rotate(corners, std::ranges::min_element(
                                   corners, {}, [](const PicturePoint& p) { return p.x + p.y; }));
  const bool is_clockwise = corners[1].x - corners[1].y > corners[3].x - corners[3].y;
  if (!is_clockwise) std::swap(corners[1], corners[3]);
  return corners;
}

double logarithm(double a, double b) { return a > 0 && b > 0 ? std::log(a / b) : 0; }

constexpr std::array<std::array<const char*, kAreas>, kAreas> kAreaNames = {
    {{"upper left", "upper edge", "upper right"},
     {"left edge", "middle", "right edge"},
     {"lower left", "lower edge", "lower right"}}};

std::size_t index_of(double part) {
  return static_cast<std::size_t>(std::clamp(static_cast<int>(part * kAreas), 0, kAreas - 1));
}

}  // namespace

ViewShape shape_of(std::span<const PicturePoint> points, const Board& board, int width,
                   int height) {
  if (points.size() != board.points()) return {};
  ViewShape shape;
  for (const PicturePoint& point : points) {
    shape.x += point.x;
    shape.y += point.y;
  }
  const auto count = static_cast<double>(points.size());
  shape.x /= count * width;
  shape.y /= count * height;
  const auto columns = static_cast<std::size_t>(board.columns);
  const std::array<PicturePoint, 4> corners = from_upper_left(
      {points.front(), points[columns - 1], points.back(), points[points.size() - columns]});
  shape.size = std::sqrt(area_of(corners) / (static_cast<double>(width) * height));
  shape.tilt_x = logarithm(distance(corners[0], corners[3]), distance(corners[1], corners[2]));
  shape.tilt_y = logarithm(distance(corners[0], corners[1]), distance(corners[3], corners[2]));
  return shape;
}

double covered_part(std::span<const View> views, int width, int height) {
  std::vector<cv::Point2f> all;
  for (const View& view : views)
    for (const PicturePoint& point : view.points) all.emplace_back(point.x, point.y);
  double area = 0;
  if (all.size() < 3) return area;
  (void)pictures::call_opencv("measuring an area", [&] {
    std::vector<cv::Point2f> around;
    cv::convexHull(all, around);
    area = cv::contourArea(around);
  });
  return area / (static_cast<double>(width) * height);
}

ViewCollector::ViewCollector(const Board& board, int width, int height)
    : board_(board), width_(width), height_(height) {}

ViewCollector::Verdict ViewCollector::offer(const std::vector<PicturePoint>& points,
                                            std::string name) {
  const bool still = is_still(points);
  last_ = points;
  if (!still) return Verdict::kMoving;
  if (!is_new(shape_of(points, board_, width_, height_))) return Verdict::kSimilar;
  take({.name = std::move(name), .points = points});
  return Verdict::kTaken;
}

void ViewCollector::take(View view) {
  shapes_.push_back(shape_of(view.points, board_, width_, height_));
  for (const PicturePoint& point : view.points) {
    const auto x = static_cast<double>(point.x) / width_;
    const auto y = static_cast<double>(point.y) / height_;
    ++points_in_.at(index_of(y)).at(index_of(x));
  }
  views_.push_back(std::move(view));
}

bool ViewCollector::is_still(const std::vector<PicturePoint>& points) const {
  if (last_.size() != points.size()) return false;
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) sum += distance(points[i], last_[i]);
  return sum / static_cast<double>(points.size()) <= kStillMax * width_;
}

bool ViewCollector::is_new(const ViewShape& shape) const {
  return std::ranges::all_of(shapes_, [&](const ViewShape& other) {
    return std::abs(shape.x - other.x) + std::abs(shape.y - other.y) +
               std::abs(shape.size - other.size) + std::abs(shape.tilt_x - other.tilt_x) +
               std::abs(shape.tilt_y - other.tilt_y) >
           kDifferenceMin;
  });
}

std::vector<std::string> ViewCollector::missing() const {
  std::vector<std::string> all;
  for (std::size_t y = 0; y < kAreas; ++y)
    for (std::size_t x = 0; x < kAreas; ++x)
      if (points_in_.at(y).at(x) < kPointsInAreaMin)
        all.push_back(fmt::format("bring the board to the {}", kAreaNames.at(y).at(x)));
  if (all.empty() && covered_part(views_, width_, height_) < kCoveredMin)
    all.emplace_back("bring the board farther into the corners of the picture");
  const auto tilted = [&](double ViewShape::*tilt) {
    return std::ranges::count_if(shapes_, [&](const ViewShape& shape) {
             return std::abs(shape.*tilt) >= kTiltMin;
           }) >= kTiltedMin;
  };
  if (!tilted(&ViewShape::tilt_x)) all.emplace_back("tilt its left or right edge to the camera");
  if (!tilted(&ViewShape::tilt_y)) all.emplace_back("tilt its upper or lower edge to the camera");
  if (std::ranges::none_of(shapes_, [](const ViewShape& s) { return s.size >= kNearMin; }))
    all.emplace_back("bring the board nearer");
  return all;
}

}  // namespace rack::camera_calibrate
