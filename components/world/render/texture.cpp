#include "components/world/render/texture.h"

#include <algorithm>
#include <bit>

#include <opencv2/imgproc.hpp>

namespace rack::world {

namespace {

cv::Mat mat_of(Texture::Level& level) {
  return {level.height, level.width, CV_8UC4, level.pixels.data()};
}

bool is_power_of_two(int side) { return std::has_single_bit(static_cast<unsigned>(side)); }

}  // namespace

Texture::Texture(const Colour& colour) : Texture(1, 1, {colour.packed()}) {}

Texture::Texture(int width, int height, std::vector<std::uint32_t> pixels)
    : repeats_(is_power_of_two(width) && is_power_of_two(height)) {
  levels_.push_back({width, height, std::move(pixels)});
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    Level& from = levels_.back();
    Level to{std::max(1, from.width / 2), std::max(1, from.height / 2), {}};
    to.pixels.resize(static_cast<std::size_t>(to.width) * static_cast<std::size_t>(to.height));
    cv::Mat smaller = mat_of(to);
    cv::resize(mat_of(from), smaller, smaller.size(), 0, 0, cv::INTER_AREA);
    levels_.push_back(std::move(to));
  }
}

}  // namespace rack::world
