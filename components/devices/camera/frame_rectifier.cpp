#include "components/devices/camera/frame_rectifier.h"

#include <array>

#include <opencv2/core.hpp>

#include "components/pictures/opencv_call.h"

namespace rack::device {
namespace {

using pictures::has_16_bits;
using pictures::kNative16;
using pictures::PictureSize;
using pictures::PixelLayout;
using pictures::PixelView;
using tims::Errc;
using tims::Error;
using tims::Result;

constexpr std::size_t kDecodedMax = 3 * std::size_t{pictures::kRectifiedPixelsMax};
constexpr double kNoColour = 128;  // of U and V

bool shares_colours(PixelLayout layout) {
  return layout == PixelLayout::kYuyv || layout == PixelLayout::kUyvy;
}

std::uint32_t format_of(PixelLayout layout) {
  return layout == PixelLayout::kGrey ? video::kGrey : video::kBgr24;
}

// Channels of a pair of pixels.
struct Pair {
  std::array<int, 2> luma;
  std::array<int, 2> colour;
};
constexpr Pair channels_of(PixelLayout layout) {
  return layout == PixelLayout::kYuyv ? Pair{{0, 2}, {1, 3}} : Pair{{1, 3}, {0, 2}};
}

cv::Mat rows_of(PictureSize size, int channels, const std::byte* bytes, std::size_t line_bytes) {
  return {static_cast<int>(size.height), static_cast<int>(size.width), CV_8UC(channels),
          const_cast<std::byte*>(bytes), line_bytes};
}

}  // namespace

Result<void> FrameRectifier::prepare(PictureSize size) {
  if (rectifier_ && size.width == size_.width && size.height == size_.height) return {};
  rectifier_.reset();
  colours_.reset();
  const auto fitting = pictures::calibration_for(
      calibration_, static_cast<std::int32_t>(size.width), static_cast<std::int32_t>(size.height));
  if (!fitting) return fitting.error();
  auto made = pictures::Rectifier::make(*fitting);
  if (!made) return made.error();
  rectifier_ = std::move(*made);
  size_ = size;
  return {};
}

Result<FrameRectifier::Frame> FrameRectifier::rectify(const VideoHead& head,
                                                      std::span<const std::byte> frame, u16 mode) {
  if (!can_rectify(mode) || head.format == video::kDepth16)
    return Error(Errc::kInvalidArgument,
                 "range, disparity and raw modes are not rectified: set calibration to an empty "
                 "text");
  if (is_jpeg(head.format)) {
    const PixelLayout layout = mode == camera_mode::kMono8 ? PixelLayout::kGrey : PixelLayout::kBgr;
    const auto size = jpeg_.decode(frame, layout, kDecodedMax, decoded_);
    if (!size) return size.error();
    if (auto good = prepare(*size); !good) return good.error();
    return rectify_plain({.layout = layout, .size = *size, .bytes = decoded_}, format_of(layout));
  }
  const auto layout = layout_of_format(head.format);
  if (!layout)
    return Error(Errc::kInvalidArgument,
                 "frames of format " + letters_of(head.format) + " cannot be rectified");
  const PixelView view{.layout = *layout,
                       .size = {head.width, head.height},
                       .bytes = frame,
                       .line_bytes = head.line_bytes};
  if (!view.is_whole())
    return Error(Errc::kMalformed, "frame of " + std::to_string(frame.size()) +
                                       " bytes does not have the size given by the camera");
  if (auto good = prepare(view.size); !good) return good.error();
  if (is_bayer(*layout)) {
    if (auto made = converter_.convert(view, PixelLayout::kBgr, decoded_); !made)
      return made.error();
    return rectify_plain({.layout = PixelLayout::kBgr, .size = view.size, .bytes = decoded_},
                         video::kBgr24);
  }
  if (has_16_bits(*layout)) return rectify_numbers(view, head.format);
  return shares_colours(*layout) ? rectify_pairs(view, head, mode)
                                 : rectify_plain(view, head.format);
}

// In the order of this machine, because means are computed.
Result<FrameRectifier::Frame> FrameRectifier::rectify_numbers(const PixelView& view,
                                                              std::uint32_t format) {
  if (view.layout == kNative16) return rectify_plain(view, format);
  if (auto made = converter_.convert(view, kNative16, decoded_); !made) return made.error();
  return rectify_plain({.layout = kNative16, .size = view.size, .bytes = decoded_},
                       format ^ video::kBigEndian);
}

Result<FrameRectifier::Frame> FrameRectifier::rectify_plain(const PixelView& view,
                                                            std::uint32_t format) {
  const bool is_wide = has_16_bits(view.layout);
  const std::size_t line = view.size.width * bytes_of(view.layout);
  made_.resize(line * view.size.height);
  auto done =
      rectifier_->rectify({.bytes = view.bytes,
                           .channels = is_wide ? 1 : static_cast<int>(bytes_of(view.layout)),
                           .channel_bytes = is_wide ? 2 : 1,
                           .line_bytes = view.line_bytes},
                          made_);
  if (!done) return done.error();
  return Frame{.head = {.format = format,
                        .width = view.size.width,
                        .height = view.size.height,
                        .line_bytes = static_cast<std::uint32_t>(line)},
               .bytes = made_};
}

Result<FrameRectifier::Frame> FrameRectifier::rectify_pairs(const PixelView& view,
                                                            const VideoHead& head, u16 mode) {
  if (auto grey = converter_.convert(view, PixelLayout::kGrey, luma_); !grey) return grey.error();
  const PixelView luma{.layout = PixelLayout::kGrey, .size = view.size, .bytes = luma_};
  if (mode == camera_mode::kMono8) return rectify_plain(luma, video::kGrey);
  const PictureSize half{view.size.width / 2, view.size.height};
  if (!colours_) {
    auto made = pictures::Rectifier::make(pictures::scaled(calibration_,
                                                           static_cast<std::int32_t>(half.width),
                                                           static_cast<std::int32_t>(half.height)));
    if (!made) return made.error();
    colours_ = std::move(*made);
  }
  rectified_luma_.resize(luma_.size());
  for (auto* const colour : {&colour_, &rectified_colour_}) colour->resize(luma_.size());
  made_.resize(2 * luma_.size());
  const std::size_t line = std::max(std::size_t{view.line_bytes}, std::size_t{2} * view.size.width);
  const cv::Mat pairs = rows_of(half, 4, view.bytes.data(), line);
  const auto [y, uv] = channels_of(view.layout);
  auto done = pictures::call_opencv("dividing a picture", [&] {
    cv::Mat colour = rows_of(half, 2, colour_.data(), view.size.width);
    const std::array colours = {uv[0], 0, uv[1], 1};
    cv::mixChannels(&pairs, 1, &colour, 1, colours.data(), 2);
  });
  if (done) done = rectifier_->rectify({.bytes = luma_}, rectified_luma_);
  if (done)
    done = colours_->rectify({.bytes = colour_, .channels = 2, .border = kNoColour},
                             rectified_colour_);
  if (!done) return done.error();
  done = pictures::call_opencv("joining a picture", [&] {
    const std::array parts = {rows_of(half, 2, rectified_luma_.data(), view.size.width),
                              rows_of(half, 2, rectified_colour_.data(), view.size.width)};
    cv::Mat joined = rows_of(half, 4, made_.data(), std::size_t{2} * view.size.width);
    const std::array channels = {0, y[0], 1, y[1], 2, uv[0], 3, uv[1]};
    cv::mixChannels(parts.data(), parts.size(), &joined, 1, channels.data(), 4);
  });
  if (!done) return done.error();
  return Frame{.head = {.format = head.format,
                        .width = view.size.width,
                        .height = view.size.height,
                        .line_bytes = 2 * view.size.width},
               .bytes = made_};
}

}  // namespace rack::device
