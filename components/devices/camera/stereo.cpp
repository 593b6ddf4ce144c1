#include "components/devices/camera/stereo.h"

#include <algorithm>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "components/pictures/opencv_call.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;

constexpr int kFraction = 16;
constexpr int kStep = 16;  // OpenCV takes numbers of disparities that are multiples of it

std::size_t pixels_of(const cv::Mat& matrix) { return matrix.total(); }

cv::Ptr<cv::StereoMatcher> make_matcher(const StereoSettings& settings, int disparities) {
  constexpr int kCap = 31;     // of gradients
  constexpr int kConfirm = 1;  // pixels between a match and that from right to left
  if (settings.method == StereoMethod::kSemiGlobal) {
    // Costs of a change by one pixel and by more, as OpenCV recommends.
    const int area = settings.block * settings.block;
    return cv::StereoSGBM::create(0, disparities, settings.block, 8 * area, 32 * area, kConfirm,
                                  kCap, settings.unique);
  }
  auto matcher = cv::StereoBM::create(disparities, settings.block);
  matcher->setPreFilterType(cv::StereoBM::PREFILTER_XSOBEL);
  matcher->setPreFilterCap(kCap);
  matcher->setTextureThreshold(settings.texture_min * settings.block * settings.block);
  matcher->setUniquenessRatio(settings.unique);
  matcher->setDisp12MaxDiff(kConfirm);
  return matcher;
}

}  // namespace

struct Stereo::Matcher {
  explicit Matcher(const StereoSettings& settings)
      : disparities((settings.disparities + kStep - 1) / kStep * kStep),
        half(settings.block / 2),
        algorithm(make_matcher(settings, disparities)) {}

  // OpenCV searches only where the whole range is inside the right picture, which would exclude a
  // margin at the left. So both get one, and what was found in it is discarded.
  void match(const cv::Mat& pair, int width) {
    cv::copyMakeBorder(pair.colRange(0, width), left, 0, 0, disparities, 0, cv::BORDER_REPLICATE);
    cv::copyMakeBorder(pair.colRange(width, 2 * width), right, 0, 0, disparities, 0,
                       cv::BORDER_REPLICATE);
    algorithm->compute(left, right, raw);
    raw.colRange(disparities, disparities + width).convertTo(found, CV_16U);  // negative: unknown
    for (int y = 0; y < found.rows; ++y) {
      auto* const line = found.ptr<std::uint16_t>(y);
      for (int x = 0; x < std::min(width, disparities + half); ++x)
        if (line[x] > std::max(0, x - half) * kFraction) line[x] = 0;
    }
  }

  int disparities;
  int half;
  cv::Ptr<cv::StereoMatcher> algorithm;
  cv::Mat left;
  cv::Mat right;
  cv::Mat raw;
  cv::Mat found;
  cv::Mat distances;
};

Stereo::Stereo(const StereoSettings& settings) : settings_(settings) {}

Stereo::~Stereo() = default;

Result<std::span<const std::uint16_t>> Stereo::match(std::span<const std::byte> pair, int width,
                                                     int height) {
  if (width < 1 || height < 1 ||
      pair.size() < 2 * static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height))
    return Error(Errc::kMalformed, "the stereo pair has fewer bytes than its size requires");
  auto done = pictures::call_opencv("matching a stereo pair", [&] {
    if (!matcher_) matcher_ = std::make_unique<Matcher>(settings_);
    if (std::min(width, height) <= settings_.block) {  // nothing can be known
      matcher_->found.create(height, width, CV_16U);
      matcher_->found.setTo(0);
      return;
    }
    const cv::Mat both(height, 2 * width, CV_8U, const_cast<std::byte*>(pair.data()));
    matcher_->match(both, width);
  });
  if (!done) return done.error();
  return std::span<const std::uint16_t>(matcher_->found.ptr<std::uint16_t>(),
                                        pixels_of(matcher_->found));
}

Result<std::span<const std::uint16_t>> Stereo::ranges(double scale) {
  if (!matcher_) return Error(Errc::kInvalidArgument, "no stereo pair was matched yet");
  auto done = pictures::call_opencv(
      "ranges of a stereo pair", [&] { cv::divide(scale, matcher_->found, matcher_->distances); });
  if (!done) return done.error();
  return std::span<const std::uint16_t>(matcher_->distances.ptr<std::uint16_t>(),
                                        pixels_of(matcher_->distances));
}

}  // namespace rack::device
