#include "components/geometry/dxf_curves.h"

#include <algorithm>
#include <cmath>

#include "components/geometry/pose.h"

namespace rack {

namespace {

constexpr double kChord = 5 * kPi / 180;
constexpr double kRounding = 1e-9;  // rad: a full circle has 72 chords, not 73

double count_of_chords(double sweep) {
  return std::max(1.0, std::ceil((std::abs(sweep) - kRounding) / kChord));
}

}  // namespace

std::vector<DxfPoint> chords(const DxfEllipse& ellipse, double first, double sweep) {
  const auto count = static_cast<std::size_t>(count_of_chords(sweep));
  std::vector<DxfPoint> points;
  points.reserve(count + 1);
  for (std::size_t i = 0; i <= count; ++i) {
    const double at = first + sweep * static_cast<double>(i) / static_cast<double>(count);
    const double c = std::cos(at);
    const double s = std::sin(at);
    points.push_back({ellipse.centre.x + c * ellipse.major.x + s * ellipse.minor.x,
                      ellipse.centre.y + c * ellipse.major.y + s * ellipse.minor.y});
  }
  return points;
}

double dxf_sweep(double first, double last) {
  const double sweep = std::fmod(last - first, 2 * kPi);
  return sweep > kRounding ? sweep : sweep + 2 * kPi;
}

void add_bulge(DxfPoint from, DxfPoint to, double bulge, std::vector<DxfPoint>& points) {
  const double sweep = 4 * std::atan(bulge);
  if (count_of_chords(sweep) > 1) {
    const double across = (1 - bulge * bulge) / (4 * bulge);
    const DxfPoint centre{(from.x + to.x) / 2 - (to.y - from.y) * across,
                          (from.y + to.y) / 2 + (to.x - from.x) * across};
    const DxfPoint radius{from.x - centre.x, from.y - centre.y};
    const auto arc = chords({centre, radius, {-radius.y, radius.x}}, 0, sweep);
    points.insert(points.end(), arc.begin() + 1, arc.end() - 1);
  }
  points.push_back(to);
}

}  // namespace rack
