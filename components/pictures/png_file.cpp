#include "components/pictures/png_file.h"

#include <algorithm>
#include <type_traits>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "components/pictures/jpeg.h"
#include "components/pictures/opencv_call.h"
#include "components/pictures/plain_text.h"

namespace rack::pictures {

namespace {

using tims::Result;

// As OpenCV encodes it: grey of 8 or 16 bits, or blue, green and red. Owns its pixels.
struct Bitmap {
  std::vector<std::byte> pixels{};
  cv::Mat mat{};
};

cv::Mat matrix(PictureSize size, int type, std::vector<std::byte>& pixels) {
  return {static_cast<int>(size.height), static_cast<int>(size.width), type, pixels.data()};
}

Result<Bitmap> of_jpeg(std::span<const std::byte> jpeg) {
  Bitmap bitmap;
  const auto size = Jpeg().decode(jpeg, PixelLayout::kBgr, kPngPixelsMax, bitmap.pixels);
  if (!size) return size.error();
  bitmap.mat = matrix(*size, CV_8UC3, bitmap.pixels);
  return bitmap;
}

Result<Bitmap> of_pixels(const PixelView& view) {
  const std::uint64_t needed =
      std::uint64_t{view.size.width} * view.size.height * bytes_of(view.layout);
  if (view.bytes.size() != needed)
    return tims::Error(tims::Errc::kMalformed,
                       "the picture has not as many bytes as its size needs");
  const auto form = [&]() -> std::pair<PixelLayout, int> {
    if (view.layout == PixelLayout::kGrey) return {PixelLayout::kGrey, CV_8UC1};
    if (view.layout == PixelLayout::kBig16) return {kNative16, CV_16UC1};
    return {PixelLayout::kBgr, CV_8UC3};
  };
  const auto [layout, type] = form();
  Bitmap bitmap;
  if (auto made = PixelConverter().convert(view, layout, bitmap.pixels); !made) return made.error();
  bitmap.mat = matrix(view.size, type, bitmap.pixels);
  return bitmap;
}

cv::Mat in_colours(const cv::Mat& picture) {
  cv::Mat grey = picture;
  if (picture.depth() == CV_16U) cv::normalize(picture, grey, 0, 255, cv::NORM_MINMAX, CV_8U);
  cv::Mat colours = grey;
  if (grey.channels() == 1) cv::cvtColor(grey, colours, cv::COLOR_GRAY2BGR);
  return colours;
}

// The label is above the box, or below its upper edge at the upper edge of the picture.
void draw(const LabelledBox& box, cv::Mat& picture) {
  const cv::Scalar green(60, 230, 60);
  const cv::Scalar black(0, 0, 0);
  const auto inside = [](std::int64_t at, int size) {
    return static_cast<int>(std::clamp<std::int64_t>(at, -1, size));
  };
  const cv::Point from(inside(box.left, picture.cols), inside(box.top, picture.rows));
  const cv::Point to(inside(std::int64_t{box.left} + box.width, picture.cols),
                     inside(std::int64_t{box.top} + box.height, picture.rows));
  cv::rectangle(picture, from, to, black, 3);
  cv::rectangle(picture, from, to, green, 1);

  constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
  constexpr double kScale = 0.45;
  const std::string label = plain_text(box.label);
  int below = 0;
  const cv::Size size = cv::getTextSize(label, kFont, kScale, 1, &below);
  const int high = size.height + below + 2;
  const cv::Point corner(std::clamp(from.x, 0, std::max(0, picture.cols - size.width)),
                         from.y >= high ? from.y - high : std::max(from.y, 0) + 2);
  cv::rectangle(picture, cv::Rect(corner, cv::Size(size.width, high)), black, cv::FILLED);
  cv::putText(picture, label, corner + cv::Point(0, size.height + 1), kFont, kScale, green, 1,
              cv::LINE_AA);
}

}  // namespace

Result<std::vector<std::byte>> encode_png(const CameraPicture& picture,
                                          std::span<const LabelledBox> boxes) {
  auto bitmap = picture.jpeg.empty() ? of_pixels(picture.pixels) : of_jpeg(picture.jpeg);
  if (!bitmap) return bitmap.error();
  std::vector<unsigned char> encoded;
  const auto done = call_opencv("encoding PNG", [&] {
    cv::Mat shown = boxes.empty() ? bitmap->mat : in_colours(bitmap->mat);
    for (const LabelledBox& box : boxes) draw(box, shown);
    cv::imencode(".png", shown, encoded);
  });
  if (!done) return done.error();
  const auto bytes = std::as_bytes(std::span(encoded));
  return std::vector<std::byte>(bytes.begin(), bytes.end());
}

}  // namespace rack::pictures

extern "C" [[gnu::visibility("default")]] void rack_encode_png(
    const rack::pictures::CameraPicture& picture,
    std::span<const rack::pictures::LabelledBox> boxes, tims::Result<std::vector<std::byte>>& png) {
  png = rack::pictures::encode_png(picture, boxes);
}

static_assert(std::is_same_v<decltype(&rack_encode_png), rack::pictures::EncodePng>);
