// Conversions between layouts of pixels, by OpenCV's cvtColor. Lines may be padded; memory is that
// of the caller, so that no conversion allocates any once its buffers have their size.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "components/pictures/jpeg_frame.h"
#include "tims/result.h"

namespace rack::pictures {

// kRggb to kBggr: one colour per pixel, named by the first two pixels of the first two lines.
enum class PixelLayout : std::uint8_t {
  kGrey,
  kRgb,
  kBgr,
  kYuyv,
  kUyvy,
  kLittle16,
  kBig16,
  kRggb,
  kGbrg,
  kGrbg,
  kBggr
};

// Numbers of 16 bits as this machine, and so OpenCV, has them.
inline constexpr PixelLayout kNative16 =
    std::endian::native == std::endian::little ? PixelLayout::kLittle16 : PixelLayout::kBig16;
constexpr bool has_16_bits(PixelLayout layout) {
  return layout == PixelLayout::kLittle16 || layout == PixelLayout::kBig16;
}

constexpr bool is_bayer(PixelLayout layout) { return layout >= PixelLayout::kRggb; }

constexpr std::size_t bytes_of(PixelLayout layout) {
  if (layout == PixelLayout::kGrey || is_bayer(layout)) return 1;
  return layout == PixelLayout::kRgb || layout == PixelLayout::kBgr ? 3 : 2;
}

struct PixelView {
  PixelLayout layout = PixelLayout::kGrey;
  PictureSize size{};
  std::span<const std::byte> bytes{};
  std::size_t line_bytes = 0;  // distance of lines; 0: without padding

  // Whether there are as many bytes as the size requires.
  [[nodiscard]] bool is_whole() const;
};

class PixelConverter {
 public:
  static bool can_convert(PixelLayout from, PixelLayout to);

  // YUYV and UYVY are of ITU-R BT.601 with limited range (Y 16 to 235), as cameras send them, when
  // they become RGB or BGR. BGR to UYVY is for JPEG, which has the full range.
  // kInvalidArgument: there is no such conversion. kMalformed: not as many bytes as the size
  // requires, or an odd width of pixels that share their colours in pairs. `pixels` is resized.
  tims::Result<void> convert(const PixelView& from, PixelLayout to, std::vector<std::byte>& pixels);

 private:
  void uyvy_of_bgr(const PixelView& from, std::vector<std::byte>& pixels);

  std::vector<std::byte> full_;  // Y Cr Cb of each pixel
  std::vector<std::byte> half_;  // of each pair of pixels
};

// The pixels that share their colours: pairs of YUYV and UYVY, squares of kRggb and the like.
PictureSize group_of(PixelLayout layout);

// Every n-th group of pixels of every n-th line of groups, unchanged. `group` is 1x1, 2x1 or 2x2.
// The result is in `pixels`, or the picture itself. kInvalidArgument: no pixel is left, or n is not
// 1 to kThinningMax.
inline constexpr int kThinningMax = 16;
tims::Result<PixelView> thinned(const PixelView& picture, PictureSize group, int n,
                                std::vector<std::byte>& pixels);

// Shares (0 to 1) of the pixels of the lowest 1/`part` of the lines: those whose channel is at most
// `low`, and those whose channel is at least `high`.
struct Shares {
  double dark = 0;
  double bright = 0;
};
std::optional<Shares> shares_of(const PixelView& picture, int channel, int part, int low, int high);

// Mean colour differences of an area of YUYV or UYVY; empty if it is not inside the picture.
struct ColourMeans {
  double u = 0;
  double v = 0;
};
struct PixelArea {
  std::uint32_t left = 0;
  std::uint32_t top = 0;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
};
std::optional<ColourMeans> colours_of(const PixelView& picture, const PixelArea& area);

// Mean of a channel of the pixels in the middle 1/`part` of each side, of some of the lines.
std::optional<double> mean_of(const PixelView& picture, int channel, int part);

}  // namespace rack::pictures
