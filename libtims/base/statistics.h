// Statistics of measured values. Pure functions.
#pragma once

#include <span>
#include <vector>

namespace tims::base {

// Quantile: the value that the fraction `part` (0 to 1) of all values does not exceed, without
// interpolation; 0 for no values.
double quantile(std::vector<double> values, double part);
double mean(std::span<const double> values);

}  // namespace tims::base
