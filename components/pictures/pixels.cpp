#include "components/pictures/pixels.h"

#include <algorithm>
#include <array>
#include <string>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "components/pictures/opencv_call.h"

namespace rack::pictures {
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
constexpr std::array<Conversion, 28> kConversions = {{
    {kYuyv, kGrey, kFirst},
    {kUyvy, kGrey, kSecond},
    {kRgb, kGrey, cv::COLOR_RGB2GRAY},
    {kBgr, kGrey, cv::COLOR_BGR2GRAY},
    {kBgr, kRgb, cv::COLOR_BGR2RGB},
    {kYuyv, kRgb, cv::COLOR_YUV2RGB_YUYV},
    {kUyvy, kRgb, cv::COLOR_YUV2RGB_UYVY},
    {kGrey, kRgb, cv::COLOR_GRAY2RGB},
    {kGrey, kBgr, cv::COLOR_GRAY2BGR},
    {kRgb, kBgr, cv::COLOR_RGB2BGR},
    {kYuyv, kBgr, cv::COLOR_YUV2BGR_YUYV},
    {kUyvy, kBgr, cv::COLOR_YUV2BGR_UYVY},
    {kYuyv, kUyvy, kSwap},
    {kBgr, kUyvy, kPairs},
    {kLittle16, kBig16, kSwap},
    {kBig16, kLittle16, kSwap},
    {kRggb, kGrey, cv::COLOR_BayerRGGB2GRAY},
    {kGbrg, kGrey, cv::COLOR_BayerGBRG2GRAY},
    {kGrbg, kGrey, cv::COLOR_BayerGRBG2GRAY},
    {kBggr, kGrey, cv::COLOR_BayerBGGR2GRAY},
    {kRggb, kRgb, cv::COLOR_BayerRGGB2RGB},
    {kGbrg, kRgb, cv::COLOR_BayerGBRG2RGB},
    {kGrbg, kRgb, cv::COLOR_BayerGRBG2RGB},
    {kBggr, kRgb, cv::COLOR_BayerBGGR2RGB},
    {kRggb, kBgr, cv::COLOR_BayerRGGB2BGR},
    {kGbrg, kBgr, cv::COLOR_BayerGBRG2BGR},
    {kGrbg, kBgr, cv::COLOR_BayerGRBG2BGR},
    {kBggr, kBgr, cv::COLOR_BayerBGGR2BGR},
}};

const Conversion* find_conversion(PixelLayout from, PixelLayout to) {
  static constexpr Conversion kSame{kGrey, kGrey, kCopy};
  if (from == to) return &kSame;
  const auto* const found = std::ranges::find_if(kConversions, [&](const Conversion& conversion) {
    return conversion.from == from && conversion.to == to;
  });
  return found == kConversions.end() ? nullptr : found;
}

// Of each `n` * `size` channels the first `size`.
void take_first(std::size_t size, const cv::Mat& from, cv::Mat& to) {
  std::array<int, 16> channels{};
  for (std::size_t i = 0; i < size; ++i)
    channels.at(2 * i) = channels.at(2 * i + 1) = static_cast<int>(i);
  cv::mixChannels(&from, 1, &to, 1, channels.data(), size);
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
  return bytes.size() >=
         std::uint64_t{stride_of(*this)} * (size.height - 1) + size.width * bytes_of(layout);
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
  return call_opencv("converting a picture", [&] {
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

PictureSize group_of(PixelLayout layout) {
  if (is_bayer(layout)) return {2, 2};
  return is_pairwise(layout) ? PictureSize{2, 1} : PictureSize{1, 1};
}

// A line of a thinned picture is a line of a matrix with wider lines and pixels: no arithmetic.
Result<PixelView> thinned(const PixelView& picture, PictureSize group, int n,
                          std::vector<std::byte>& pixels) {
  if (n == 1) return picture;
  if (!picture.is_whole())
    return Error(Errc::kMalformed, "the picture has fewer bytes than its size requires");
  const auto step = static_cast<std::uint32_t>(std::clamp(n, 1, kThinningMax));
  const std::uint32_t columns = picture.size.width / group.width / step;
  const std::uint32_t lines = picture.size.height / group.height / step;
  if (n < 1 || n > kThinningMax || columns == 0 || lines == 0)
    return Error(Errc::kInvalidArgument, "a picture of " + std::to_string(picture.size.width) +
                                             "x" + std::to_string(picture.size.height) +
                                             " pixels cannot be reduced to 1/" + std::to_string(n));
  const std::size_t bytes = bytes_of(picture.layout) * group.width;  // of a group in a line
  const std::size_t stride = stride_of(picture);
  const std::size_t line = columns * bytes;
  pixels.resize(line * lines * group.height);
  const auto done = call_opencv("reducing a picture", [&] {
    for (std::uint32_t part = 0; part < group.height; ++part) {
      const cv::Mat source(static_cast<int>(lines), static_cast<int>(columns),
                           CV_8UC(static_cast<int>(bytes * step)),
                           const_cast<std::byte*>(picture.bytes.data()) + part * stride,
                           stride * group.height * step);
      cv::Mat target(static_cast<int>(lines), static_cast<int>(columns),
                     CV_8UC(static_cast<int>(bytes)), pixels.data() + part * line,
                     line * group.height);
      take_first(bytes, source, target);
    }
  });
  if (!done) return done.error();
  return PixelView{.layout = picture.layout,
                   .size = {columns * group.width, lines * group.height},
                   .bytes = pixels};
}

std::optional<Shares> shares_of(const PixelView& picture, int channel, int part, int low,
                                int high) {
  if (part < 1 || !picture.is_whole()) return std::nullopt;
  const std::uint32_t lines = std::max(1U, picture.size.height / static_cast<std::uint32_t>(part));
  const PixelView lowest{
      .layout = picture.layout,
      .size = {picture.size.width, lines},
      .bytes = picture.bytes.subspan((picture.size.height - lines) * stride_of(picture)),
      .line_bytes = picture.line_bytes};
  constexpr int kValues = 256;
  constexpr std::array kRange = {0.0F, 256.0F};
  const float* ranges = kRange.data();
  Shares shares;
  const auto done = call_opencv("exposure", [&] {
    cv::Mat counts;
    const cv::Mat source = matrix(lowest);
    cv::calcHist(&source, 1, &channel, {}, counts, 1, &kValues, &ranges);
    const auto sum = [&](int from, int to) {
      return from < to ? cv::sum(counts.rowRange(from, to))[0] : 0;
    };
    const double all = sum(0, kValues);
    shares = {.dark = sum(0, std::clamp(low + 1, 0, kValues)) / all,
              .bright = sum(std::clamp(high, 0, kValues), kValues) / all};
  });
  return done ? std::optional(shares) : std::nullopt;
}

std::optional<ColourMeans> colours_of(const PixelView& picture, const PixelArea& area) {
  const std::uint32_t pairs = area.width / 2;
  if (!is_pairwise(picture.layout) || !picture.is_whole() || pairs == 0 || area.height == 0 ||
      area.left > picture.size.width || area.width > picture.size.width - area.left ||
      area.top > picture.size.height || area.height > picture.size.height - area.top)
    return std::nullopt;
  const std::size_t stride = stride_of(picture);
  const std::size_t at = area.top * stride + area.left / 2 * std::size_t{4};
  const bool is_uyvy = picture.layout == kUyvy;
  ColourMeans means;
  const auto done = call_opencv("white balance", [&] {
    const cv::Mat source(static_cast<int>(area.height), static_cast<int>(pairs), CV_8UC4,
                         const_cast<std::byte*>(picture.bytes.data()) + at, stride);
    const cv::Scalar mean = cv::mean(source);
    means = {.u = mean[is_uyvy ? 0 : 1], .v = mean[is_uyvy ? 2 : 3]};
  });
  return done ? std::optional(means) : std::nullopt;
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
  const auto done = call_opencv("brightness", [&] { mean = cv::mean(matrix(middle))[channel]; });
  return done ? std::optional(mean) : std::nullopt;
}

}  // namespace rack::pictures
