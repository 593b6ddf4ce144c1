#include "components/vision/person_place.h"

#include <cmath>

namespace rack::vision {

using scan3d::Place;

namespace {

// Standard deviations, measured with people at known places (people_finder_test.cpp).
constexpr double kHeightDeviation = 0.08;  // part of the height of the box
constexpr double kFeetDeviation = 0.04;    // of the row of the feet, part of the height of the box
constexpr double kMiddleDeviation = 0.06;  // part of the width of the box
constexpr double kTiltDeviation = 0.5 * kPi / 180;  // of a robot that drives
constexpr double kContradiction = 3;                // standard deviations
constexpr double kNearest = 300;                    // mm
constexpr double kHorizontalLeast = 0.2;            // of the line of sight: not straight up or down

// A ray through a pixel: its direction along the ground, and how steeply it goes down.
struct Ray {
  double direction = 0;
  double slope = 0;
};

std::optional<Ray> ray_of(const ImagePoint& pixel, const CameraGeometry& camera) {
  const Lens& lens = camera.lens();
  const Place to{1, (pixel.column - lens.cx) / lens.fx, (pixel.row - lens.cy) / lens.fy};
  const Place ray = camera.on_robot(to) + camera.on_robot({}) * -1;
  const double along = std::hypot(ray.x, ray.y);
  if (!(along > kHorizontalLeast * std::hypot(along, ray.z))) return std::nullopt;
  return Ray{std::atan2(ray.y, ray.x), ray.z / along};
}

// The inverse of a distance, and its variance.
struct Inverse {
  double value = 0;
  double variance = 0;
};

double squared(double value) { return value * value; }

}  // namespace

std::optional<PersonPlace> place_of(const PersonBox& box, const CameraGeometry& camera,
                                    int picture_height, const PersonMeasures& measures) {
  if (!(box.height > 0) || !(box.width > 0) || !(measures.height > 0)) return std::nullopt;
  const auto head = ray_of({box.middle(), box.head()}, camera);
  const auto feet = ray_of({box.middle(), box.feet()}, camera);
  const auto middle = ray_of({box.middle(), (box.head() + box.feet()) / 2}, camera);
  if (!head || !feet || !middle) return std::nullopt;
  const double tall = feet->slope - head->slope;
  if (!(tall > 0)) return std::nullopt;

  Inverse inverse{tall / measures.height, 0};
  inverse.variance = squared(inverse.value) *
                     (squared(kHeightDeviation) + squared(measures.deviation / measures.height));
  const Place lens = camera.on_robot({});
  if (box.feet() < picture_height && lens.z < 0) {
    const double row_deviation = kFeetDeviation * box.height / camera.lens().fy;
    const Inverse by_feet{feet->slope / -lens.z,
                          (squared(row_deviation) + squared(kTiltDeviation)) / squared(lens.z)};
    if (squared(by_feet.value - inverse.value) >
        squared(kContradiction) * (by_feet.variance + inverse.variance))
      return std::nullopt;
    const double variance = 1 / (1 / inverse.variance + 1 / by_feet.variance);
    inverse = {variance * (inverse.value / inverse.variance + by_feet.value / by_feet.variance),
               variance};
  }
  // Also false for values that are not numbers.
  if (!(inverse.value * measures.range_max >= 1) || !(inverse.value * kNearest <= 1))
    return std::nullopt;
  const double range = 1 / inverse.value;
  return PersonPlace{.x = lens.x + range * std::cos(middle->direction),
                     .y = lens.y + range * std::sin(middle->direction),
                     .range = range,
                     .direction = middle->direction,
                     .deviation_range = std::sqrt(inverse.variance) * squared(range),
                     .deviation_across = kMiddleDeviation * box.width / camera.lens().fx * range,
                     .height = tall * range};
}

double apparent_height(double height, double range, const CameraGeometry& camera) {
  return camera.lens().fy * height / range;
}

}  // namespace rack::vision
