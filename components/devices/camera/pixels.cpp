#include "components/devices/camera/pixels.h"

#include <algorithm>
#include <array>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "components/pictures/opencv_call.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;

bool is_pairwise(PixelLayout layout) {
  return layout == PixelLayout::kYuyv || layout == PixelLayout::kUyvy;
}

std::size_t stride_of(const PixelView& view) {
  return std::max(view.line_bytes, view.size.width * bytes_of(view.layout));
}

// OpenCV's headers of our memory. The constant one is only read.
cv::Mat matrix(const PixelView& view) {
  return {static_cast<int>(view.size.height), static_cast<int>(view.size.width),
          CV_8UC(static_cast<int>(bytes_of(view.layout))),
          const_cast<std::byte*>(view.bytes.data()), stride_of(view)};
}
cv::Mat matrix(PictureSize size, int channels, std::vector<std::byte>& pixels) {
  pixels.resize(std::size_t{size.width} * size.height * static_cast<std::size_t>(channels));
  return {static_cast<int>(size.height), static_cast<int>(size.width), CV_8UC(channels),
          pixels.data()};
}

struct Conversion {
  PixelLayout from;
  PixelLayout to;
  int code;
};

// Codes of our own beside OpenCV's.
constexpr int kCopy = -1;
constexpr int kSwap = -2;   // each pair of bytes
constexpr int kFirst = -3;  // of each pair of bytes
constexpr int kSecond = -4;
constexpr int kPairs = -5;  // colours of pairs of pixels

using enum PixelLayout;
constexpr std::array<Conversion, 18> kConversions = {{
    {kGrey, kGrey, kCopy},
    {kYuyv, kGrey, kFirst},
    {kUyvy, kGrey, kSecond},
    {kRgb, kGrey, cv::COLOR_RGB2GRAY},
    {kBgr, kGrey, cv::COLOR_BGR2GRAY},
    {kRgb, kRgb, kCopy},
    {kBgr, kRgb, cv::COLOR_BGR2RGB},
    {kYuyv, kRgb, cv::COLOR_YUV2RGB_YUYV},
    {kUyvy, kRgb, cv::COLOR_YUV2RGB_UYVY},
    {kGrey, kRgb, cv::COLOR_GRAY2RGB},
    {kBgr, kBgr, kCopy},
    {kRgb, kBgr, cv::COLOR_RGB2BGR},
    {kYuyv, kBgr, cv::COLOR_YUV2BGR_YUYV},
    {kUyvy, kBgr, cv::COLOR_YUV2BGR_UYVY},
    {kUyvy, kUyvy, kCopy},
    {kYuyv, kUyvy, kSwap},
    {kBgr, kUyvy, kPairs},
    {kLittle16, kBig16, kSwap},
}};

const Conversion* find_conversion(PixelLayout from, PixelLayout to) {
  const auto* const found = std::ranges::find_if(kConversions, [&](const Conversion& conversion) {
    return conversion.from == from && conversion.to == to;
  });
  return found == kConversions.end() ? nullptr : found;
}

void run(int code, const cv::Mat& from, cv::Mat& to) {
  constexpr std::array kSwapped = {0, 1, 1, 0};
  if (code == kCopy)
    from.copyTo(to);
  else if (code == kSwap)
    cv::mixChannels(&from, 1, &to, 1, kSwapped.data(), 2);
  else if (code == kFirst || code == kSecond)
    cv::extractChannel(from, to, code == kFirst ? 0 : 1);
  else
    cv::cvtColor(from, to, code);
}

}  // namespace

bool PixelView::is_whole() const {
  constexpr std::uint32_t kSideMax = 0xFFFF;
  if (size.width == 0 || size.height == 0 || size.width > kSideMax || size.height > kSideMax)
    return false;
  return bytes.size() >= stride_of(*this) * (size.height - 1) + size.width * bytes_of(layout);
}

bool PixelConverter::can_convert(PixelLayout from, PixelLayout to) {
  return find_conversion(from, to) != nullptr;
}

Result<void> PixelConverter::convert(const PixelView& from, PixelLayout to,
                                     std::vector<std::byte>& pixels) {
  const Conversion* const conversion = find_conversion(from.layout, to);
  if (conversion == nullptr)
    return Error(Errc::kInvalidArgument, "no conversion between these layouts of pixels");
  if (!from.is_whole())
    return Error(Errc::kMalformed, "the picture has fewer bytes than its size requires");
  if ((is_pairwise(from.layout) || is_pairwise(to)) && from.size.width % 2 != 0)
    return Error(Errc::kMalformed, "an odd width: two pixels share one colour in this format");
  return pictures::call_opencv("converting a picture", [&] {
    if (conversion->code == kPairs) return uyvy_of_bgr(from, pixels);
    cv::Mat target = matrix(from.size, static_cast<int>(bytes_of(to)), pixels);
    run(conversion->code, matrix(from), target);
    CV_Assert(target.data == reinterpret_cast<uchar*>(pixels.data()));
  });
}

// Two pixels share the mean of their colours.
void PixelConverter::uyvy_of_bgr(const PixelView& from, std::vector<std::byte>& pixels) {
  const PictureSize pairs{from.size.width / 2, from.size.height};
  cv::Mat full = matrix(from.size, 3, full_);
  cv::Mat half = matrix(pairs, 3, half_);
  cv::cvtColor(matrix(from), full, cv::COLOR_BGR2YCrCb);
  // At half the width, a linear interpolation is the mean of two pixels.
  cv::resize(full, half, half.size(), 0, 0, cv::INTER_LINEAR);
  // Two pixels as one of six channels, followed by the means: Y0 Cr0 Cb0 Y1 Cr1 Cb1, Y Cr Cb.
  const std::array sources = {matrix(pairs, 6, full_), half};
  cv::Mat target = matrix(pairs, 4, pixels);
  constexpr std::array kUyvyOf = {8, 0, 0, 1, 7, 2, 3, 3};
  cv::mixChannels(sources.data(), sources.size(), &target, 1, kUyvyOf.data(), 4);
}

std::optional<double> mean_of(const PixelView& picture, int channel, int part) {
  if (part < 1 || !picture.is_whole()) return std::nullopt;
  const auto divisor = static_cast<std::uint32_t>(part);
  const auto [width, height] = picture.size;
  const std::uint32_t w = std::max(1U, width / divisor);
  const std::uint32_t h = std::max(1U, height / divisor);
  // Some lines suffice: these are a matrix whose lines are farther apart.
  constexpr std::uint32_t kLines = 64;
  const std::uint32_t every = 1 + h / kLines;
  const std::size_t stride = stride_of(picture);
  const std::size_t at = (height - h) / 2 * stride + (width - w) / 2 * bytes_of(picture.layout);
  const PixelView middle{.layout = picture.layout,
                         .size = {w, (h + every - 1) / every},
                         .bytes = picture.bytes.subspan(at),
                         .line_bytes = stride * every};
  double mean = 0;
  const auto done =
      pictures::call_opencv("brightness", [&] { mean = cv::mean(matrix(middle))[channel]; });
  return done ? std::optional(mean) : std::nullopt;
}

}  // namespace rack::device
