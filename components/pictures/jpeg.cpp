#include "components/pictures/jpeg.h"

#include <algorithm>
#include <string>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "components/pictures/opencv_call.h"

namespace rack::pictures {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;

Error too_big() { return {Errc::kTooBig, "the picture exceeds the maximum size of a message"}; }

int type_of(PixelLayout layout) { return layout == PixelLayout::kGrey ? CV_8UC1 : CV_8UC3; }

}  // namespace

Jpeg::Jpeg() : settings_{cv::IMWRITE_JPEG_QUALITY, 0} {
  // Takes the tables of a picture that was encoded with the standard tables.
  const std::vector<std::byte> dot(3);
  std::vector<std::byte> picture;
  constexpr std::size_t kDotMax = 4096;
  if (encode({.layout = PixelLayout::kBgr, .size = {1, 1}, .bytes = dot}, 50, kDotMax, picture))
    tables_ = huffman_tables(picture);
}

Result<PictureSize> Jpeg::decode(std::span<const std::byte> jpeg, PixelLayout layout,
                                 std::size_t bytes_max, std::vector<std::byte>& pixels) {
  const auto size = jpeg_size(jpeg);
  const std::uint64_t bytes =
      size ? std::uint64_t{size->width} * size->height * bytes_of(layout) : std::uint64_t{0};
  if (bytes > bytes_max)
    return Error(Errc::kTooBig, "a picture of " + std::to_string(size->width) + "x" +
                                    std::to_string(size->height) + " pixels");
  if (jpeg.size() > bytes_max) return too_big();
  if (auto good = check_jpeg(jpeg); !good) return good.error();
  pixels.resize(static_cast<std::size_t>(bytes));
  cv::Mat target(static_cast<int>(size->height), static_cast<int>(size->width), type_of(layout),
                 pixels.data());
  const cv::Mat source(1, static_cast<int>(jpeg.size()), CV_8U,
                       const_cast<std::byte*>(jpeg.data()));
  // Cameras that are turned note that beside the picture; its size and calibration do not change.
  const int flags = cv::IMREAD_IGNORE_ORIENTATION |
                    (layout == PixelLayout::kGrey ? cv::IMREAD_GRAYSCALE : cv::IMREAD_COLOR);
  auto done = call_opencv("decoding a JPEG picture", [&] { cv::imdecode(source, flags, &target); });
  if (!done) return done.error();
  if (target.data != reinterpret_cast<uchar*>(pixels.data()))
    return Error(Errc::kMalformed, "damaged picture");
  return *size;
}

Result<void> Jpeg::encode(const PixelView& picture, int quality, std::size_t bytes_max,
                          std::vector<std::byte>& jpeg) {
  constexpr std::uint32_t kSideMax = 65500;  // limit of the format
  if (!picture.is_whole() || picture.size.width > kSideMax || picture.size.height > kSideMax)
    return Error(Errc::kInvalidArgument, "the picture has fewer pixels than its size requires");
  PixelView view = picture;
  if (view.layout != PixelLayout::kGrey && view.layout != PixelLayout::kBgr) {
    if (auto made = converter_.convert(picture, PixelLayout::kBgr, bgr_); !made) return made;
    view = {.layout = PixelLayout::kBgr, .size = picture.size, .bytes = bgr_};
  }
  const std::size_t line = std::max(view.line_bytes, view.size.width * bytes_of(view.layout));
  const cv::Mat source(static_cast<int>(view.size.height), static_cast<int>(view.size.width),
                       type_of(view.layout), const_cast<std::byte*>(view.bytes.data()), line);
  settings_.back() = std::clamp(quality, 1, 100);
  auto done = call_opencv("encoding a JPEG picture",
                          [&] { cv::imencode(".jpg", source, encoded_, settings_); });
  if (!done) return done;
  if (encoded_.size() > bytes_max) return too_big();
  const auto bytes = std::as_bytes(std::span(encoded_));
  jpeg.assign(bytes.begin(), bytes.end());
  return {};
}

}  // namespace rack::pictures
