// Of measured values. Pure.
#pragma once

#include <span>
#include <vector>

namespace tims::base {

// The value that this part of all (0 to 1) does not exceed, as near as there is one; 0 without any.
double quantile(std::vector<double> values, double part);
double mean(std::span<const double> values);

}  // namespace tims::base
