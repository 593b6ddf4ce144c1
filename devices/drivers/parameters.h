// Lists of parameters that are made of several.
#pragma once

#include <algorithm>
#include <array>

#include "rack/parameters.h"

namespace rack::device {

template <std::size_t N, std::size_t M>
constexpr std::array<ParameterInfo, N + M> joined(const std::array<ParameterInfo, N>& first,
                                                  const std::array<ParameterInfo, M>& second) {
  std::array<ParameterInfo, N + M> all{};
  std::ranges::copy(second, std::ranges::copy(first, all.begin()).out);
  return all;
}

}  // namespace rack::device
