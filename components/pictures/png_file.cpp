#include "components/pictures/png_file.h"

#include <type_traits>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "components/pictures/opencv_call.h"

namespace rack::pictures {

namespace {

cv::Mat of_opencv(const RawPicture& picture) {
  const auto mat = [&](int type) {
    return cv::Mat(picture.height, picture.width, type,
                   const_cast<std::byte*>(picture.bytes.data()));
  };
  cv::Mat converted;
  switch (picture.form) {
    case RawForm::kGrey:
      return mat(CV_8UC1);
    case RawForm::kGrey16: {
      // Two bytes of a pixel as two channels, exchanged.
      const cv::Mat bytes = mat(CV_8UC2);
      cv::Mat exchanged(picture.height, picture.width, CV_8UC2);
      cv::mixChannels({bytes}, {exchanged}, {0, 1, 1, 0});
      return cv::Mat(picture.height, picture.width, CV_16UC1, exchanged.data).clone();
    }
    case RawForm::kRgb:
      cv::cvtColor(mat(CV_8UC3), converted, cv::COLOR_RGB2BGR);
      return converted;
    case RawForm::kUyvy:
      cv::cvtColor(mat(CV_8UC2), converted, cv::COLOR_YUV2BGR_UYVY);
      return converted;
  }
  return converted;
}

}  // namespace

tims::Result<std::vector<std::byte>> encode_png(const RawPicture& picture) {
  constexpr std::int32_t kSideMax = 65535;
  const auto is_side = [](std::int32_t side) { return side > 0 && side <= kSideMax; };
  if (!is_side(picture.width) || !is_side(picture.height) ||
      static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height) *
              bytes_of(picture.form) !=
          picture.bytes.size() ||
      (picture.form == RawForm::kUyvy && picture.width % 2 != 0))
    return tims::Error(tims::Errc::kMalformed,
                       "the picture has not as many bytes as its size needs");
  std::vector<unsigned char> encoded;
  const auto done =
      call_opencv("encoding PNG", [&] { cv::imencode(".png", of_opencv(picture), encoded); });
  if (!done) return done.error();
  const auto bytes = std::as_bytes(std::span(encoded));
  return std::vector<std::byte>(bytes.begin(), bytes.end());
}

}  // namespace rack::pictures

extern "C" [[gnu::visibility("default")]] void rack_encode_png(
    const rack::pictures::RawPicture& picture, tims::Result<std::vector<std::byte>>& png) {
  png = rack::pictures::encode_png(picture);
}

static_assert(std::is_same_v<decltype(&rack_encode_png), rack::pictures::EncodePng>);
