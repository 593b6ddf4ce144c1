#include "components/perception/box_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "components/geometry/pose.h"

namespace rack::perception {
namespace {

constexpr std::size_t kBoxFitPointsMax = 64;  // points of a cluster that the search uses
constexpr int kCoarse = 6;                    // deg
constexpr int kQuarter = 90;
constexpr double kBoxFitNearest = 10;  // mm: smaller distances to a side count as this one

struct Extent {
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();

  void add(double value) {
    least = std::min(least, value);
    most = std::max(most, value);
  }
  [[nodiscard]] double size() const { return most - least; }
  [[nodiscard]] double middle() const { return (most + least) / 2; }
  [[nodiscard]] double to_side(double value) const { return std::min(most - value, value - least); }
};

struct Sides {
  Extent along;
  Extent across;
};

struct Direction {
  double c;
  double s;
  [[nodiscard]] double along(const MapPoint& p) const { return p.x * c + p.y * s; }
  [[nodiscard]] double across(const MapPoint& p) const { return p.y * c - p.x * s; }
};

Direction direction_of(double heading) { return {std::cos(heading), std::sin(heading)}; }

Sides sides_of(std::span<const MapPoint> points, const Direction& direction, std::size_t step) {
  Sides sides;
  for (std::size_t i = 0; i < points.size(); i += step) {
    sides.along.add(direction.along(points[i]));
    sides.across.add(direction.across(points[i]));
  }
  return sides;
}

double closeness(std::span<const MapPoint> points, double heading, std::size_t step) {
  const Direction direction = direction_of(heading);
  const Sides sides = sides_of(points, direction, step);
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); i += step) {
    const double away = std::min(sides.along.to_side(direction.along(points[i])),
                                 sides.across.to_side(direction.across(points[i])));
    sum += 1 / std::max(away, kBoxFitNearest);
  }
  return sum;
}

}  // namespace

Box fit_box(std::span<const MapPoint> points) {
  const std::size_t step = points.size() / (kBoxFitPointsMax + 1) + 1;
  int best = 0;
  double most = -1;
  const auto attempt = [&](int degrees) {
    const double close = closeness(points, radians(degrees), step);
    if (close <= most) return;
    most = close;
    best = degrees;
  };
  for (int degrees = 0; degrees < kQuarter; degrees += kCoarse) attempt(degrees);
  const int coarse = best;
  for (int degrees = coarse - kCoarse + 1; degrees < coarse + kCoarse; ++degrees) attempt(degrees);
  best = (best + kQuarter) % kQuarter;
  const Direction direction = direction_of(radians(best));
  const Sides sides = sides_of(points, direction, 1);
  const double along = sides.along.middle();
  const double across = sides.across.middle();
  return {.centre = {along * direction.c - across * direction.s,
                     along * direction.s + across * direction.c},
          .heading = radians(best),
          .length = sides.along.size(),
          .width = sides.across.size()};
}

}  // namespace rack::perception
