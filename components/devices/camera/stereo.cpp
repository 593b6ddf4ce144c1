#include "components/devices/camera/stereo.h"

#include <algorithm>
#include <cstdlib>

namespace rack::device {
namespace {

constexpr int kFraction = 16;

int grey(std::span<const std::byte> pixels, int at) {
  return std::to_integer<int>(pixels[static_cast<std::size_t>(at)]);
}

std::size_t index(int value) { return static_cast<std::size_t>(value); }

// Minimum of the parabola through three costs, in 1/16.
int lowest_between(std::uint32_t before, std::uint32_t at, std::uint32_t after) {
  const auto b = static_cast<int>(before) - static_cast<int>(at);
  const auto a = static_cast<int>(after) - static_cast<int>(at);
  if (a + b <= 0) return 0;
  return std::clamp((b - a) * kFraction / (2 * (a + b)), -kFraction / 2, kFraction / 2);
}

}  // namespace

// Adds the differences of a line to the sums of the columns, or subtracts them.
void Stereo::add_line(std::span<const std::byte> pair, int width, int y, int sign) {
  const auto left = pair.subspan(index(y) * index(2 * width), index(width));
  const auto right = pair.subspan(index(y) * index(2 * width) + index(width), index(width));
  const int far = settings_.disparities;
  constexpr int kNothingThere = 255;
  for (int x = 0; x < width; ++x) {
    std::uint16_t* const sums = &columns_[index(x) * index(far)];
    const int own = grey(left, x);
    for (int d = 0; d < far; ++d) {
      const int difference = d <= x ? std::abs(own - grey(right, x - d)) : kNothingThere;
      sums[d] = static_cast<std::uint16_t>(sums[d] + sign * difference);
    }
    const int texture = x > 0 ? std::abs(own - grey(left, x - 1)) : 0;
    textures_[index(x)] = static_cast<std::uint16_t>(textures_[index(x)] + sign * texture);
  }
}

void Stereo::match_line(int width, std::uint16_t* out) {
  const int far = settings_.disparities;
  const int half = settings_.block / 2;
  const int area = settings_.block * settings_.block;
  // Sums of blocks are sliding sums of the columns.
  std::vector<std::uint32_t>& costs = costs_;
  std::fill(costs.begin(), costs.end(), 0U);
  for (int x = half; x < width - half; ++x) {
    std::uint32_t* const sums = &costs[index(x) * index(far)];
    if (x == half) {
      for (int i = 0; i < settings_.block; ++i)
        for (int d = 0; d < far; ++d) sums[d] += columns_[index(i) * index(far) + index(d)];
      continue;
    }
    const std::uint32_t* const before = sums - far;
    const std::uint16_t* const comes = &columns_[index(x + half) * index(far)];
    const std::uint16_t* const goes = &columns_[index(x - half - 1) * index(far)];
    for (int d = 0; d < far; ++d) sums[d] = before[d] + comes[d] - goes[d];
  }
  for (int x = half; x < width - half; ++x) {
    const std::uint32_t* const sums = &costs[index(x) * index(far)];
    const auto best = static_cast<int>(std::min_element(sums, sums + far) - sums);
    int texture = 0;
    for (int i = -half; i <= half; ++i) texture += textures_[index(x + i)];
    // The block must be completely inside the right picture.
    const bool is_inside = x - best >= half;
    bool is_known =
        is_inside && best > 0 && best < far - 1 && texture >= settings_.texture_min * area;
    for (int d = 0; is_known && d < far; ++d)
      is_known = std::abs(d - best) <= 1 ||
                 sums[d] * 100 > sums[best] * static_cast<std::uint32_t>(100 + settings_.unique);
    // Matching from the right picture must give the same pair.
    for (int d = 0; is_known && d < far && x - best + d < width - half; ++d)
      is_known = costs[index(x - best + d) * index(far) + index(d)] >= sums[best];
    if (is_known)
      out[x] = static_cast<std::uint16_t>(
          best * kFraction + lowest_between(sums[best - 1], sums[best], sums[best + 1]));
  }
}

std::span<const std::uint16_t> Stereo::match(std::span<const std::byte> pair, int width,
                                             int height) {
  const int half = settings_.block / 2;
  disparities_.assign(index(width) * index(height), 0);
  if (width <= settings_.block || height <= settings_.block || settings_.disparities < 4 ||
      pair.size() < 2 * index(width) * index(height))
    return disparities_;
  columns_.assign(index(width) * index(settings_.disparities), 0);
  costs_.resize(columns_.size());
  textures_.assign(index(width), 0);
  for (int y = 0; y < height; ++y) {
    add_line(pair, width, y, 1);
    if (y >= settings_.block) add_line(pair, width, y - settings_.block, -1);
    if (y >= settings_.block - 1) match_line(width, &disparities_[index(y - half) * index(width)]);
  }
  return disparities_;
}

}  // namespace rack::device
