// A grey picture in somebody else's memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace rack::vision {

struct GreyView {
  int width = 0;
  int height = 0;
  std::span<const std::uint8_t> pixels{};  // width * height

  [[nodiscard]] bool is_whole() const {
    return width >= 0 && height >= 0 &&
           pixels.size() >= static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  }
};

}  // namespace rack::vision
