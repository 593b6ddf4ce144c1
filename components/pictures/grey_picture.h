// Pictures of maps in files, decoded and encoded by OpenCV. Pure. Read are PGM (text or binary,
// maximum value 1 to 65535) and PNG (any depth, palettes and colours become grey, transparency is
// ignored); written are binary PGM and PNG with 8 or 16 bits.
//
// Other formats that OpenCV knows are refused: their decoders would be open to hostile files, and
// their size is not known before decoding.
#pragma once

#include <cstdint>
#include <string>
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

enum class GreyFormat : std::uint8_t { kPgm, kPng };

// The file of a picture, whose white is 255 (8 bits) or 65535 (16 bits). Error kInvalidArgument:
// another white, a value above it, or not one value for each pixel; kTooBig: more than
// kGreyPixelsMax pixels, or kGreySideMax on a side.
tims::Result<std::string> write_grey(const GreyPicture& picture, GreyFormat format);
inline constexpr std::int32_t kGreySideMax = 1'000'000;  // libpng's limit

// The name of this function in librack-pictures, which programs load when they read a picture of a
// map: OpenCV's decoders bring 120 libraries, which would multiply the time to start and the locked
// memory of programs that never read one. Calls read_grey().
inline constexpr const char* kReadGreySymbol = "rack_read_grey";
using ReadGrey = void (*)(const std::string_view& bytes, tims::Result<GreyPicture>& picture);

}  // namespace rack::pictures
