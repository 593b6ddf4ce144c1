// Pictures of cameras as PNG, encoded by OpenCV. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tims/result.h"

namespace rack::pictures {

enum class RawForm : std::uint8_t {
  kGrey,
  kGrey16,  // high byte first
  kRgb,
  kUyvy,  // U Y0 V Y1, ITU-R BT.601 with limited range
};

constexpr std::size_t bytes_of(RawForm form) {
  if (form == RawForm::kGrey) return 1;
  return form == RawForm::kRgb ? 3 : 2;
}

struct RawPicture {
  RawForm form = RawForm::kGrey;
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::span<const std::byte> bytes{};  // row by row, without padding
};

// kMalformed: the size and the bytes do not fit together, or an odd width of kUyvy.
tims::Result<std::vector<std::byte>> encode_png(const RawPicture& picture);

// The name of this function in librack-pictures (grey_picture.h). Calls encode_png().
inline constexpr const char* kEncodePngSymbol = "rack_encode_png";
using EncodePng = void (*)(const RawPicture& picture, tims::Result<std::vector<std::byte>>& png);

}  // namespace rack::pictures
