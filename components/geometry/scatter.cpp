#include "components/geometry/scatter.h"

#include <algorithm>
#include <cmath>

namespace rack {

Scatter::Moments Scatter::about_mean() const {
  const auto [x, y] = mean();
  return {xx_ / points_ - x * x, xy_ / points_ - x * y, yy_ / points_ - y * y};
}

Scatter::Variances Scatter::variances() const {
  const Moments about = about_mean();
  const double middle = (about.xx + about.yy) / 2;
  const double apart = std::hypot((about.xx - about.yy) / 2, about.xy);
  return {middle + apart, std::max(middle - apart, 0.0)};
}

double Scatter::direction() const {
  const Moments about = about_mean();
  return std::atan2(2 * about.xy, about.xx - about.yy) / 2;
}

}  // namespace rack
