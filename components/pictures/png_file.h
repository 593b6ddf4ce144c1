// Pictures of cameras as PNG, also with boxes around what was recognised in them, by OpenCV. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "components/pictures/pixels.h"
#include "tims/result.h"

namespace rack::pictures {

// JPEG, or pixels where there is none.
struct CameraPicture {
  std::span<const std::byte> jpeg{};
  PixelView pixels{};
};

// Pixels; may be partly outside of the picture.
struct LabelledBox {
  std::int32_t left = 0;
  std::int32_t top = 0;
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::string label{};
};

// Pixels of 16 bits keep them, unless there are boxes: the picture then has colours, and shows them
// from the darkest to the brightest. kMalformed: the picture is damaged, or has not as many bytes
// as its size requires; its lines are not padded. kTooBig: its pixels need more than kPngPixelsMax
// bytes.
tims::Result<std::vector<std::byte>> encode_png(const CameraPicture& picture,
                                                std::span<const LabelledBox> boxes = {});

inline constexpr std::size_t kPngPixelsMax = std::size_t{256} << 20;

// The name of this function in librack-pictures (grey_picture.h). Calls encode_png().
inline constexpr const char* kEncodePngSymbol = "rack_encode_png";
using EncodePng = void (*)(const CameraPicture& picture, std::span<const LabelledBox> boxes,
                           tims::Result<std::vector<std::byte>>& png);

}  // namespace rack::pictures
