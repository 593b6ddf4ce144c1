#include "components/pictures/raster_canvas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <type_traits>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "base/text.h"
#include "components/pictures/dashes.h"
#include "components/pictures/opencv_call.h"
#include "components/pictures/plain_text.h"

namespace rack::pictures {
namespace {

constexpr int kFiner = 4;       // a pixel has 4 x 4 of the mask
constexpr int kShift = 4;       // OpenCV's coordinates with 4 binary digits
constexpr double kFar = 1e5;    // pixels; further coordinates would overflow
constexpr double kNear = 0.25;  // pixels: points that are nearer to each other are one
constexpr int kFull = 255;      // of the mask

// OpenCV fills shapes with the pixels under their outline: they are this much wider and higher.
constexpr double kBorder = 1;

// Hershey's letters at scale 1: capital letters are 21 high, between the middles of strokes.
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kCapital = 21;
// As in DejaVu Sans, which the SVG is made for, in parts of the size of the text.
constexpr double kCapitalOfSize = 0.73;
constexpr double kStrokeOfSize = 0.09;
constexpr double kBoldOfSize = 0.17;

double limited(double pixels) {
  return std::isfinite(pixels) ? std::clamp(pixels, -kFar, kFar) : 0;
}

int whole(double pixels) { return static_cast<int>(std::lround(pixels)); }

// The colour of "#rrggbb", as blue, green, red; black if it is not one.
cv::Vec3f colour_of(std::string_view text) {
  const auto code = text.size() == 7 && text.front() == '#'
                        ? tims::base::parse_number<std::uint32_t>(text.substr(1), 16)
                        : std::nullopt;
  const std::uint32_t rgb = code.value_or(0);
  return {static_cast<float>(rgb & 0xFF), static_cast<float>(rgb >> 8 & 0xFF),
          static_cast<float>(rgb >> 16 & 0xFF)};
}

// The pixels that a box touches.
cv::Rect pixels_of(const Box& box) {
  const int left = static_cast<int>(std::floor(limited(box.x)));
  const int top = static_cast<int>(std::floor(limited(box.y)));
  const int right = static_cast<int>(std::ceil(limited(box.x + box.width)));
  const int bottom = static_cast<int>(std::ceil(limited(box.y + box.height)));
  return {left, top, std::max(right - left, 0), std::max(bottom - top, 0)};
}

// The box around spots, wider by `margin`.
Box box_around(std::span<const Spot> spots, double margin) {
  Spot low = spots.front();
  Spot high = low;
  for (const Spot& spot : spots) {
    low = {std::min(low.x, spot.x), std::min(low.y, spot.y)};
    high = {std::max(high.x, spot.x), std::max(high.y, spot.y)};
  }
  return {low.x - margin, low.y - margin, high.x - low.x + 2 * margin, high.y - low.y + 2 * margin};
}

// Straight along the picture: a line of one pixel then is not divided among two.
double on_pixels(double at, double width) {
  const bool is_odd = whole(width) % 2 == 1;
  return is_odd ? std::floor(at) + 0.5 : std::round(at);
}

// A part of the picture, finer: where a figure is drawn.
class Mask {
 public:
  explicit Mask(const cv::Rect& pixels)
      : pixels_(pixels),
        fine_(pixels.height * kFiner, pixels.width * kFiner, CV_8U, cv::Scalar::all(0)) {}

  // Each segment as a rectangle, round where segments meet. cv::polylines() draws lines of odd
  // widths only, with round ends that would close the gaps between dashes.
  void stroke(std::span<const Spot> spots, double width) {
    const double half = (width * kFiner - kBorder) / 2 / kFiner;
    for (std::size_t i = 1; i < spots.size(); ++i) {
      const Spot& a = spots[i - 1];
      const Spot& b = spots[i];
      const double length = std::hypot(b.x - a.x, b.y - a.y);
      if (!(length > 0)) continue;
      const Spot ahead{(b.x - a.x) / length, (b.y - a.y) / length};
      const double cut = std::min(kBorder / 2 / kFiner, length / 2);
      // A corner, from the middle of an end.
      const auto corner = [&](const Spot& end, double along, double aside) {
        return point(
            {end.x + along * ahead.x - aside * ahead.y, end.y + along * ahead.y + aside * ahead.x});
      };
      const std::array corners = {corner(a, cut, half), corner(b, -cut, half),
                                  corner(b, -cut, -half), corner(a, cut, -half)};
      cv::fillConvexPoly(fine_, corners.data(), static_cast<int>(corners.size()),
                         cv::Scalar::all(kFull), cv::LINE_8, kShift);
      if (i + 1 < spots.size()) disc(b, width / 2);
    }
  }
  void disc(const Spot& at, double radius) {
    const double fine_radius = std::max(radius * kFiner - kBorder / 2, 0.0);
    cv::circle(fine_, point(at), whole(fine_radius * (1 << kShift)), cv::Scalar::all(kFull),
               cv::FILLED, cv::LINE_8, kShift);
  }
  void box(double left, double top, double right, double bottom) {
    const cv::Rect filled(cv::Point(fine(left - pixels_.x), fine(top - pixels_.y)),
                          cv::Point(fine(right - pixels_.x), fine(bottom - pixels_.y)));
    const cv::Rect inside = filled & cv::Rect({}, fine_.size());
    if (!inside.empty()) fine_(inside).setTo(kFull);
  }
  // A figure of its own, whose left top corner is at a spot.
  void figure(const cv::Mat& finer, const Spot& at) {
    const cv::Rect placed({fine(at.x - pixels_.x), fine(at.y - pixels_.y)}, finer.size());
    const cv::Rect inside = placed & cv::Rect({}, fine_.size());
    if (!inside.empty()) finer(inside - placed.tl()).copyTo(fine_(inside));
  }

  [[nodiscard]] cv::Mat coverage() const {
    cv::Mat covered;
    cv::resize(fine_, covered, pixels_.size(), 0, 0, cv::INTER_AREA);
    return covered;
  }

 private:
  static int fine(double pixels) { return whole(pixels * kFiner); }
  // OpenCV's coordinates are those of the middle of a pixel.
  [[nodiscard]] cv::Point point(const Spot& spot) const {
    const auto fixed = [](double pixels) { return whole((pixels * kFiner - 0.5) * (1 << kShift)); };
    return {fixed(spot.x - pixels_.x), fixed(spot.y - pixels_.y)};
  }

  cv::Rect pixels_;
  cv::Mat fine_;
};

class RasterCanvas : public Canvas {
 public:
  RasterCanvas(int width, int height)
      : picture_(height, width, CV_8UC3, cv::Scalar::all(kFull)), clip_({}, picture_.size()) {}

  void line(const Spot& from, const Spot& to, const Pen& pen) override {
    Spot a = from;
    Spot b = to;
    if (a.x == b.x) a.x = b.x = on_pixels(a.x, pen.width);
    if (a.y == b.y) a.y = b.y = on_pixels(a.y, pen.width);
    lines(std::vector{a, b}, pen);
  }

  void lines(std::span<const Spot> spots, const Pen& pen) override {
    std::vector<Spot> line;
    for (std::size_t i = 0; i < spots.size(); ++i) {
      const Spot spot{limited(spots[i].x), limited(spots[i].y)};
      const bool is_inner = i > 0 && i + 1 < spots.size();
      if (is_inner && std::hypot(spot.x - line.back().x, spot.y - line.back().y) < kNear) continue;
      line.push_back(spot);
    }
    if (line.size() < 2) return;
    const auto lengths = dash_lengths(pen.dashes);
    paint(box_around(line, pen.width), pen.colour, pen.opacity, [&](Mask& mask) {
      if (lengths.empty()) return mask.stroke(line, pen.width);
      const Box seen = box_around(
          std::vector<Spot>{{static_cast<double>(clip_.x), static_cast<double>(clip_.y)},
                            {static_cast<double>(clip_.br().x), static_cast<double>(clip_.br().y)}},
          pen.width);
      for (const auto& dash : dashes_of(line, lengths, seen)) mask.stroke(dash, pen.width);
    });
  }

  void frame(const Box& box, const Pen& pen) override {
    const double left = on_pixels(box.x, pen.width);
    const double top = on_pixels(box.y, pen.width);
    const double right = on_pixels(box.x + box.width, pen.width);
    const double bottom = on_pixels(box.y + box.height, pen.width);
    lines(
        std::vector<Spot>{{left, top}, {right, top}, {right, bottom}, {left, bottom}, {left, top}},
        pen);
  }

  void area(const Box& box, std::string_view colour) override {
    paint(box, colour, 1,
          [&](Mask& mask) { mask.box(box.x, box.y, box.x + box.width, box.y + box.height); });
  }

  void cells(std::span<const CellRun> runs, const Spot& left_top, double cell,
             std::string_view colour) override {
    const auto clip = static_cast<cv::Rect2d>(clip_);
    paint({clip.x, clip.y, clip.width, clip.height}, colour, 1, [&](Mask& mask) {
      for (const CellRun& run : runs) {
        const double left = limited(left_top.x + run.column * cell);
        const double top = limited(left_top.y + run.row * cell);
        mask.box(left, top, limited(left + run.length * cell), limited(top + cell));
      }
    });
  }

  void dot(const Spot& at, double radius, std::string_view colour, double opacity) override {
    const Spot middle{limited(at.x), limited(at.y)};
    paint(box_around(std::span(&middle, 1), radius + 1), colour, opacity,
          [&](Mask& mask) { mask.disc(middle, radius); });
  }

  void text(const Spot& at, std::string_view content, const TextStyle& style) override {
    const std::string letters = plain_text(content);
    if (letters.empty()) return;
    const double stroke = (style.bold ? kBoldOfSize : kStrokeOfSize) * style.size * kFiner;
    const double scale = (kCapitalOfSize * style.size * kFiner - stroke) / kCapital;
    const int thickness = 2 * std::max(whole((stroke - kBorder) / 2), 1);
    int below = 0;
    const cv::Size size = cv::getTextSize(letters, kFont, scale, thickness, &below);
    const int margin = 2 * thickness;
    cv::Mat figure(size.height + below + 2 * margin, size.width + 2 * margin, CV_8U,
                   cv::Scalar::all(0));
    cv::putText(figure, letters, {margin, margin + size.height}, kFont, scale,
                cv::Scalar::all(kFull), thickness, cv::LINE_8);
    // From the left end of the baseline to the left top corner of the figure.
    const double wide = static_cast<double>(size.width) / kFiner;
    const double along = style.anchor == Anchor::kStart    ? 0
                         : style.anchor == Anchor::kMiddle ? wide / 2
                                                           : wide;
    const double before = static_cast<double>(margin) / kFiner + along;
    const double above = (margin + size.height + stroke / 2) / kFiner;
    Spot corner{limited(at.x) - before, limited(at.y) - above};
    if (style.upwards) {
      cv::rotate(figure, figure, cv::ROTATE_90_COUNTERCLOCKWISE);
      corner = {limited(at.x) - above,
                limited(at.y) + before - static_cast<double>(figure.rows) / kFiner};
    }
    const Box box{corner.x, corner.y, static_cast<double>(figure.cols) / kFiner,
                  static_cast<double>(figure.rows) / kFiner};
    paint(box, style.colour, 1, [&](Mask& mask) { mask.figure(figure, corner); });
  }

  void clip(const Box& box) override { clip_ = pixels_of(box) & cv::Rect({}, picture_.size()); }
  void end_clip() override { clip_ = cv::Rect({}, picture_.size()); }

  [[nodiscard]] std::string png() const {
    std::vector<unsigned char> bytes;
    cv::imencode(".png", picture_, bytes);
    return {bytes.begin(), bytes.end()};
  }

 private:
  // Blends a colour into the picture where `draw` draws into the mask of this box.
  template <typename Draw>
  void paint(const Box& box, std::string_view colour, double opacity, Draw draw) {
    const cv::Rect pixels = pixels_of(box) & clip_;
    if (pixels.empty()) return;
    Mask mask(pixels);
    draw(mask);
    const cv::Mat covered = mask.coverage();
    const cv::Vec3f ink = colour_of(colour);
    const auto full = static_cast<float>(std::clamp(opacity, 0.0, 1.0) / kFull);
    for (int row = 0; row < covered.rows; ++row) {
      const auto* part = covered.ptr<std::uint8_t>(row);
      auto* pixel = picture_.ptr<cv::Vec3b>(pixels.y + row) + pixels.x;
      for (int column = 0; column < covered.cols; ++column) {
        if (part[column] == 0) continue;
        const float share = full * static_cast<float>(part[column]);
        for (int i = 0; i < 3; ++i) {
          const auto before = static_cast<float>(pixel[column][i]);
          pixel[column][i] =
              static_cast<std::uint8_t>(std::lround(before + share * (ink[i] - before)));
        }
      }
    }
  }

  cv::Mat picture_;
  cv::Rect clip_;
};

}  // namespace

tims::Result<std::string> draw_png(double width, double height,
                                   const std::function<void(Canvas&)>& draw) {
  const bool is_valid = width > 0 && height > 0;  // and numbers
  if (!is_valid) return tims::Error(tims::Errc::kInvalidArgument, "the picture has no valid size");
  const double columns = std::ceil(width);
  const double rows = std::ceil(height);
  if (columns > kRasterSideMax || rows > kRasterSideMax || columns * rows > kRasterPixelsMax)
    return tims::Error(tims::Errc::kTooBig,
                       "the picture is too large: more than " + std::to_string(kRasterSideMax) +
                           " pixels on a side or " + std::to_string(kRasterPixelsMax) +
                           " in all; draw fewer curves");
  std::string png;
  auto done = call_opencv("the picture cannot be drawn", [&] {
    RasterCanvas canvas(static_cast<int>(columns), static_cast<int>(rows));
    draw(canvas);
    png = canvas.png();
  });
  if (!done) return done.error();
  return png;
}

}  // namespace rack::pictures

extern "C" [[gnu::visibility("default")]] void rack_draw_png(
    double width, double height, const std::function<void(rack::pictures::Canvas&)>& draw,
    tims::Result<std::string>& png) {
  png = rack::pictures::draw_png(width, height, draw);
}

static_assert(std::is_same_v<decltype(&rack_draw_png), rack::pictures::DrawPng>);
