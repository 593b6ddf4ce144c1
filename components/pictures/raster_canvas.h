// A drawing as PNG: drawn and encoded by OpenCV. Pure.
//
// OpenCV draws lines of whole pixels, without transparency. So every line, dot and text is drawn
// into a mask that is finer than the picture, and only as large as the figure; the average of a
// pixel's part of the mask is how much of the pixel is covered by the figure. This gives smooth
// edges, fractions of pixels, and each part of a transparent line exactly once.
//
// The font is Hershey's, which OpenCV contains, so a picture is the same on every host. It has the
// characters of ASCII (plain_text.h replaces others).
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "components/pictures/canvas.h"
#include "tims/result.h"

namespace rack::pictures {

inline constexpr std::int32_t kRasterSideMax = 32'000;        // pixels
inline constexpr std::int64_t kRasterPixelsMax = 32'000'000;  // 96 MB

// A drawing on a white canvas of this size, rounded up to whole pixels. kTooBig: the picture is too
// large; `draw` was not called.
tims::Result<std::string> draw_png(double width, double height,
                                   const std::function<void(Canvas&)>& draw);

// The name of this function in librack-pictures, which programs load when they draw a PNG
// (kReadGreySymbol says why). Calls draw_png().
inline constexpr const char* kDrawPngSymbol = "rack_draw_png";
using DrawPng = void (*)(double width, double height, const std::function<void(Canvas&)>& draw,
                         tims::Result<std::string>& png);

}  // namespace rack::pictures
