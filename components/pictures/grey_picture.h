// Pictures of maps from files: PGM (text or binary, maximum value 1 to 65535) and PNG (any depth,
// palettes and colours become grey, transparency is ignored), decoded by OpenCV. Pure.
//
// Other formats that OpenCV knows are refused: their decoders would be open to hostile files, and
// their size is not known before decoding.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "tims/result.h"

namespace rack::pictures {

struct GreyPicture {
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::uint16_t white = 255;            // value of white
  std::vector<std::uint16_t> values{};  // width * height, beginning with the top row
};

inline constexpr std::int64_t kGreyPixelsMax =
    128'000'000;  // 500 m x 500 m with cells of 50 mm, 30 000 on a side at most

// Error kMalformed: what is wrong with the picture. The size is checked before memory is allocated.
tims::Result<GreyPicture> read_grey(std::string_view bytes);

// The name of this function in librack-pictures, which programs load when they read a picture of a
// map: OpenCV's decoders bring 120 libraries, which would multiply the time to start and the locked
// memory of programs that never read one. Calls read_grey().
inline constexpr const char* kReadGreySymbol = "rack_read_grey";
using ReadGrey = void (*)(const std::string_view& bytes, tims::Result<GreyPicture>& picture);

}  // namespace rack::pictures
