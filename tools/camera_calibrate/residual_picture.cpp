#include "tools/camera_calibrate/residual_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/core.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "components/pictures/opencv_call.h"

namespace rack::camera_calibrate {
namespace {

constexpr int kMargin = 24;
constexpr int kFieldWidth = 900;  // of the picture area
constexpr int kFieldHeightMax = 1600;
constexpr int kCloud = 300;  // side of the residuals around their expected position
constexpr int kBars = 200;   // height of the error of each view
constexpr int kTitle = 30;
constexpr double kLongest = 40;  // pixels of a large residual in this picture

// Blue, green, red.
using Ink = std::array<int, 3>;
constexpr Ink kBlack = {0, 0, 0};
constexpr Ink kGreyLine = {190, 190, 190};
constexpr Ink kPale = {245, 245, 245};
constexpr Ink kPoint = {170, 120, 40};
constexpr Ink kBad = {40, 40, 210};

cv::Scalar colour_of(const Ink& ink) {
  return {static_cast<double>(ink[0]), static_cast<double>(ink[1]), static_cast<double>(ink[2])};
}

void write(cv::Mat& picture, const std::string& text, cv::Point at, double size = 0.5) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, colour_of(kBlack), 1, cv::LINE_AA);
}

// Residuals up to this length are drawn to scale: all but the largest 2 %.
double usual_length(const Calibrated& calibrated) {
  std::vector<double> lengths;
  for (const CalibratedView& view : calibrated.views)
    for (const Residual& residual : view.residuals)
      lengths.push_back(std::hypot(residual.x, residual.y));
  if (lengths.empty()) return 1;
  const auto at = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() * 98 / 100);
  std::nth_element(lengths.begin(), at, lengths.end());
  return std::max(*at, 1e-3);
}

// 1, 2 or 5 times a power of ten.
double round_below(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  const double digits = value / power;
  return power * (digits >= 5 ? 5 : digits >= 2 ? 2 : 1);
}

class ResidualPicture {
 public:
  explicit ResidualPicture(const Calibrated& calibrated)
      : calibrated_(calibrated),
        zoom_(std::min(static_cast<double>(kFieldWidth) / calibrated.calibration.width,
                       static_cast<double>(kFieldHeightMax) / calibrated.calibration.height)),
        field_(kMargin, kMargin + kTitle, kFieldWidth,
               std::max(static_cast<int>(calibrated.calibration.height * zoom_), kCloud)),
        cloud_(2 * kMargin + kFieldWidth, kMargin + kTitle, kCloud, kCloud),
        bars_(kMargin, field_.br().y + kMargin + kTitle, cloud_.br().x - kMargin, kBars),
        longest_(usual_length(calibrated)),
        picture_(bars_.br().y + kMargin + 10, cloud_.br().x + kMargin, CV_8UC3,
                 cv::Scalar::all(255)) {}

  cv::Mat draw() {
    draw_field();
    draw_cloud();
    draw_summary();
    draw_bars();
    return picture_;
  }

 private:
  void draw_field() {
    const double exaggeration = round_below(kLongest / (longest_ * zoom_));
    const auto& calibration = calibrated_.calibration;
    write(picture_,
          fmt::format("Residuals in the picture of {}x{} pixels, {:g} times as long",
                      calibration.width, calibration.height, exaggeration),
          {field_.x, field_.y - 10});
    cv::rectangle(picture_, field_, colour_of(kPale), cv::FILLED);
    cv::rectangle(picture_, field_, colour_of(kGreyLine));
    for (const CalibratedView& view : calibrated_.views)
      for (const Residual& residual : view.residuals) {
        const cv::Point2d from((residual.at.x + 0.5) * zoom_ + field_.x,
                               (residual.at.y + 0.5) * zoom_ + field_.y);
        const cv::Point2d to = from + cv::Point2d(residual.x, residual.y) * (zoom_ * exaggeration);
        line(from, to, view.is_outlier ? kBad : kPoint);
        cv::circle(picture_, cv::Point(from), 1, colour_of(kBlack), cv::FILLED, cv::LINE_AA);
      }
    const cv::Point2d middle((calibration.camera.cx + 0.5) * zoom_ + field_.x,
                             (calibration.camera.cy + 0.5) * zoom_ + field_.y);
    cv::drawMarker(picture_, cv::Point(middle), colour_of(kBlack), cv::MARKER_CROSS, 16, 1,
                   cv::LINE_AA);
  }

  // Lines stay within the picture area.
  void line(cv::Point2d from, cv::Point2d to, const Ink& ink) {
    cv::Point a(static_cast<int>(std::lround(from.x)), static_cast<int>(std::lround(from.y)));
    cv::Point b(static_cast<int>(std::lround(std::clamp(to.x, -1e4, 1e4))),
                static_cast<int>(std::lround(std::clamp(to.y, -1e4, 1e4))));
    if (cv::clipLine(field_, a, b)) cv::line(picture_, a, b, colour_of(ink), 1, cv::LINE_AA);
  }

  void draw_cloud() {
    const double ring = round_below(longest_);
    const double zoom = 0.9 * kCloud / 2 / longest_;
    const cv::Point middle(cloud_.x + kCloud / 2, cloud_.y + kCloud / 2);
    write(picture_, fmt::format("x and y; circle: {:g} pixels", ring), {cloud_.x, cloud_.y - 10});
    cv::rectangle(picture_, cloud_, colour_of(kPale), cv::FILLED);
    cv::line(picture_, {cloud_.x, middle.y}, {cloud_.br().x, middle.y}, colour_of(kGreyLine));
    cv::line(picture_, {middle.x, cloud_.y}, {middle.x, cloud_.br().y}, colour_of(kGreyLine));
    cv::circle(picture_, middle, static_cast<int>(ring * zoom), colour_of(kGreyLine), 1,
               cv::LINE_AA);
    for (const CalibratedView& view : calibrated_.views)
      for (const Residual& residual : view.residuals) {
        const cv::Point2d at = cv::Point2d(middle) + cv::Point2d(residual.x, residual.y) * zoom;
        if (std::max(std::abs(residual.x), std::abs(residual.y)) * zoom > kCloud / 2.0 - 3)
          continue;
        cv::circle(picture_, cv::Point(at), 1, colour_of(view.is_outlier ? kBad : kPoint),
                   cv::FILLED);
      }
    cv::rectangle(picture_, cloud_, colour_of(kGreyLine));
  }

  void draw_summary() {
    const auto& camera = calibrated_.calibration.camera;
    const auto& deviation = calibrated_.uncertainty;
    const auto& lens = calibrated_.calibration.distortion;
    const std::array<std::string, 8> lines = {
        fmt::format("error {:.3f} pixels, {} views", calibrated_.error, calibrated_.views.size()),
        fmt::format("fx {:.2f} +- {:.2f}", camera.fx, deviation.fx),
        fmt::format("fy {:.2f} +- {:.2f}", camera.fy, deviation.fy),
        fmt::format("cx {:.2f} +- {:.2f}", camera.cx, deviation.cx),
        fmt::format("cy {:.2f} +- {:.2f}", camera.cy, deviation.cy),
        fmt::format("k1 {:.4f}  k2 {:.4f}  k3 {:.4f}", lens.at(0), lens.at(1), lens.at(4)),
        fmt::format("p1 {:.5f}  p2 {:.5f}", lens.at(2), lens.at(3)),
        fmt::format("seen in {:.0f} % of the picture", 100 * calibrated_.covered)};
    int y = cloud_.br().y + 28;
    for (const std::string& text : lines) {
      write(picture_, text, {cloud_.x, y});
      y += 24;
    }
  }

  void draw_bars() {
    double highest = 1e-3;
    for (const CalibratedView& view : calibrated_.views) highest = std::max(highest, view.error);
    write(picture_, "Error of each view [pixels]; line: of all; red: outlier",
          {bars_.x, bars_.y - 10});
    cv::rectangle(picture_, bars_, colour_of(kPale), cv::FILLED);
    const auto height = [&](double error) {
      return static_cast<int>(0.9 * kBars * error / highest);
    };
    const auto count = static_cast<int>(calibrated_.views.size());
    for (int i = 0; i < count; ++i) {
      const CalibratedView& view = calibrated_.views.at(static_cast<std::size_t>(i));
      const int left = bars_.x + bars_.width * i / count;
      const int right = std::max(left + 1, bars_.x + bars_.width * (i + 1) / count - 2);
      cv::rectangle(picture_, cv::Point(left, bars_.br().y - height(view.error)),
                    cv::Point(right, bars_.br().y), colour_of(view.is_outlier ? kBad : kPoint),
                    cv::FILLED);
      if (count <= 40) write(picture_, std::to_string(i + 1), {left, bars_.br().y + 16}, 0.4);
    }
    const int all = bars_.br().y - height(calibrated_.error);
    cv::line(picture_, {bars_.x, all}, {bars_.br().x, all}, colour_of(kBlack));
    write(picture_, fmt::format("{:.2f}", highest),
          {bars_.x + 4, std::max(bars_.br().y - height(highest) - 4, bars_.y + 12)}, 0.4);
  }

  const Calibrated& calibrated_;
  double zoom_;
  cv::Rect field_;
  cv::Rect cloud_;
  cv::Rect bars_;
  double longest_;
  cv::Mat picture_;
};

}  // namespace

tims::Result<std::string> draw_residuals(const Calibrated& calibrated) {
  std::vector<unsigned char> png;
  auto done = pictures::call_opencv("drawing the residuals", [&] {
    cv::imencode(".png", ResidualPicture(calibrated).draw(), png);
  });
  if (!done) return done.error();
  return std::string(png.begin(), png.end());
}

}  // namespace rack::camera_calibrate
