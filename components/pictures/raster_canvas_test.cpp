#include "components/pictures/raster_canvas.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

namespace rack::pictures {
namespace raster_canvas_test {

using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

cv::Mat drawn(double width, double height, const std::function<void(Canvas&)>& draw) {
  const auto png = draw_png(width, height, draw);
  EXPECT_TRUE(png) << png.error().detail();
  return png ? cv::imdecode(std::vector<unsigned char>(png->begin(), png->end()), cv::IMREAD_COLOR)
             : cv::Mat();
}

// As 0xrrggbb.
unsigned at(const cv::Mat& picture, int x, int y) {
  const auto& pixel = picture.at<cv::Vec3b>(y, x);
  return static_cast<unsigned>(pixel[2] << 16 | pixel[1] << 8 | pixel[0]);
}

// Ink in whole pixels: how dark the picture or a part is, 1 for each black pixel.
double ink(const cv::Mat& picture) {
  double sum = 0;
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) sum += 1 - picture.at<cv::Vec3b>(y, x)[1] / 255.0;
  return sum;
}

// The columns or rows that have ink.
cv::Rect inked(const cv::Mat& picture) {
  cv::Rect found;
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
      if (at(picture, x, y) != 0xFFFFFF) found |= cv::Rect(x, y, 1, 1);
  return found;
}

TEST(RasterCanvas, IsAWhitePngOfItsSize) {
  const cv::Mat picture = drawn(30.2, 20, [](Canvas&) {});
  EXPECT_EQ(picture.size(), cv::Size(31, 20));
  EXPECT_EQ(ink(picture), 0);
}

TEST(RasterCanvas, AreasHaveTheirColours) {
  const cv::Mat picture = drawn(20, 20, [](Canvas& canvas) {
    canvas.area({2, 3, 4, 5}, "#0072b2");
    canvas.area({10.5, 10, 1, 1}, "#000000");
    canvas.area({0, 18, 2, 2}, "red");
  });
  EXPECT_EQ(at(picture, 2, 3), 0x0072B2U);
  EXPECT_EQ(at(picture, 5, 7), 0x0072B2U);
  for (const auto& [x, y] : {std::pair(1, 3), std::pair(2, 2), std::pair(6, 7), std::pair(5, 8)})
    EXPECT_EQ(at(picture, x, y), 0xFFFFFFU) << x << ", " << y;
  EXPECT_EQ(at(picture, 10, 10), 0x7F7F7FU) << "half of the pixel";
  EXPECT_EQ(at(picture, 11, 10), 0x7F7F7FU);
  EXPECT_EQ(at(picture, 0, 18), 0U) << "not a colour of ours: black";
}

TEST(RasterCanvas, LinesOfOnePixelAreSharp) {
  const cv::Mat picture = drawn(20, 20, [](Canvas& canvas) {
    canvas.line({5, 2}, {5, 18}, {});
    canvas.line({8, 10.7}, {16, 10.7}, {.colour = "#ff0000"});
  });
  EXPECT_EQ(at(picture, 5, 10), 0U);
  EXPECT_EQ(at(picture, 4, 10), 0xFFFFFFU);
  EXPECT_EQ(at(picture, 6, 10), 0xFFFFFFU);
  EXPECT_EQ(at(picture, 12, 10), 0xFF0000U);
  EXPECT_EQ(at(picture, 12, 9), 0xFFFFFFU);
  EXPECT_EQ(at(picture, 12, 11), 0xFFFFFFU);
}

TEST(RasterCanvas, WidthsOfLinesAreFractionsOfPixels) {
  for (const double width : {1.0, 1.25, 1.5, 2.0, 4.5, 9.0}) {
    const cv::Mat picture = drawn(140, 40, [&](Canvas& canvas) {
      canvas.lines(std::vector<Spot>{{20, 20}, {120, 20}}, {.width = width});
    });
    EXPECT_NEAR(ink(picture.colRange(50, 60)) / 10, width, 0.13) << width;
    const cv::Mat tilted = drawn(140, 140, [&](Canvas& canvas) {
      canvas.lines(std::vector<Spot>{{-20, 120}, {160, 20}}, {.width = width});
    });
    EXPECT_NEAR(ink(tilted.colRange(40, 100)) / 60 * std::cos(std::atan2(100, 180)), width, 0.25)
        << width;
  }
}

TEST(RasterCanvas, DashesHaveGaps) {
  const cv::Mat picture = drawn(60, 10, [](Canvas& canvas) {
    canvas.lines(std::vector<Spot>{{10, 5}, {60, 5}}, {.width = 2, .dashes = "8 4"});
  });
  EXPECT_EQ(at(picture, 14, 5), 0U);
  EXPECT_EQ(at(picture, 20, 5), 0xFFFFFFU);
  EXPECT_EQ(at(picture, 26, 5), 0U);
  EXPECT_EQ(at(picture, 32, 5), 0xFFFFFFU);
  EXPECT_NEAR(ink(picture), 2 * (4 * 8 + 2), 1) << "the last one is cut";
}

TEST(RasterCanvas, TransparencyIsThatOfTheWholeFigure) {
  const cv::Mat picture = drawn(40, 40, [](Canvas& canvas) {
    canvas.dot({10, 10}, 5, "#000000", 0.6);
    canvas.lines(std::vector<Spot>{{20, 30}, {38, 30}, {20, 30}}, {.width = 4, .opacity = 0.6});
  });
  EXPECT_EQ(at(picture, 10, 10), 0x666666U);
  EXPECT_EQ(at(picture, 30, 30), 0x666666U) << "there and back";
  const cv::Mat twice = drawn(40, 40, [](Canvas& canvas) {
    canvas.dot({10, 10}, 5, "#000000", 0.6);
    canvas.dot({10, 10}, 5, "#000000", 0.6);
  });
  EXPECT_EQ(at(twice, 10, 10), 0x292929U);
}

TEST(RasterCanvas, DotsAreRound) {
  const cv::Mat picture = drawn(40, 40, [](Canvas& canvas) {
    canvas.dot({20.5, 20.5}, 6, "#000000", 1);
  });
  EXPECT_NEAR(ink(picture), std::numbers::pi * 36, 2);
  EXPECT_EQ(inked(picture), cv::Rect(14, 14, 13, 13));
}

TEST(RasterCanvas, CellsAreRunsOfAGrid) {
  const cv::Mat picture = drawn(20, 20, [](Canvas& canvas) {
    canvas.cells(std::vector<CellRun>{{0, 1, 3}, {2, 0, 1}}, {4, 6}, 2, "#555555");
  });
  EXPECT_EQ(at(picture, 6, 6), 0x555555U);
  EXPECT_EQ(at(picture, 11, 7), 0x555555U);
  EXPECT_EQ(at(picture, 12, 7), 0xFFFFFFU);
  EXPECT_EQ(at(picture, 5, 6), 0xFFFFFFU);
  EXPECT_EQ(at(picture, 6, 8), 0xFFFFFFU);
  EXPECT_EQ(at(picture, 5, 11), 0x555555U);
  EXPECT_NEAR(ink(picture) * 255 / 0xAA, 2 * 6 + 2 * 2, 0.1);
}

TEST(RasterCanvas, NothingIsDrawnBesideTheClip) {
  const cv::Mat picture = drawn(40, 40, [](Canvas& canvas) {
    canvas.clip({10, 10, 10, 10});
    canvas.area({0, 0, 40, 40}, "#ff0000");
    canvas.clip({30, 30, 100, 100});
    canvas.lines(std::vector<Spot>{{-1e9, 35}, {1e9, 35}}, {.width = 3, .dashes = "7 3"});
    canvas.text({0, 38}, "clipped text", {});
    canvas.end_clip();
    canvas.dot({2, 2}, 1, "#000000", 1);
  });
  EXPECT_EQ(at(picture, 10, 10), 0xFF0000U);
  EXPECT_EQ(at(picture, 19, 19), 0xFF0000U);
  EXPECT_EQ(at(picture, 9, 15), 0xFFFFFFU);
  EXPECT_EQ(at(picture, 20, 15), 0xFFFFFFU);
  EXPECT_EQ(ink(picture({20, 20, 10, 20})), 0);
  EXPECT_GT(ink(picture({30, 30, 10, 10})), 10);
  EXPECT_GT(ink(picture({0, 0, 4, 4})), 2);
}

TEST(RasterCanvas, TextIsAtItsAnchor) {
  const auto text = [](const Spot& spot, const TextStyle& style) {
    return inked(drawn(200, 200, [&](Canvas& canvas) { canvas.text(spot, "HELLO", style); }));
  };
  const cv::Rect start = text({50, 100}, {.size = 20});
  EXPECT_NEAR(start.x, 51, 2);
  EXPECT_NEAR(start.br().y, 101, 1) << "on the baseline";
  EXPECT_NEAR(start.height, 0.73 * 20, 2.5);
  EXPECT_NEAR(start.width, 5 * 0.65 * 20, 8);
  const cv::Rect middle = text({100, 100}, {.size = 20, .anchor = Anchor::kMiddle});
  EXPECT_NEAR(middle.x + middle.width / 2.0, 100, 2);
  const cv::Rect end = text({150, 100}, {.size = 20, .anchor = Anchor::kEnd});
  EXPECT_NEAR(end.br().x, 149, 2);
  EXPECT_GT(text({50, 100}, {.size = 40}).height, 1.9 * start.height);
}

TEST(RasterCanvas, TextUpwardsIsReadFromBelow) {
  const cv::Mat across = drawn(200, 200, [](Canvas& canvas) {
    canvas.text({100, 100}, "L7 metres", {.size = 20});
  });
  const cv::Mat upwards = drawn(200, 200, [](Canvas& canvas) {
    canvas.text({100, 100}, "L7 metres", {.size = 20, .upwards = true});
  });
  cv::Mat turned;
  cv::rotate(across, turned, cv::ROTATE_90_COUNTERCLOCKWISE);
  EXPECT_NEAR(ink(upwards), ink(turned), 1);
  cv::Mat difference;
  cv::absdiff(upwards, turned, difference);
  EXPECT_LT(cv::mean(difference)[0], 0.3);
}

TEST(RasterCanvas, BoldIsDarker) {
  const auto of = [](bool bold) {
    return ink(drawn(100, 40, [&](Canvas& canvas) {
      canvas.text({5, 30}, "robot", {.size = 16, .bold = bold});
    }));
  };
  EXPECT_GT(of(true), 1.3 * of(false));
}

// Hershey's font lacks them: each is drawn as it is documented in plain_text.h.
TEST(RasterCanvas, TextsFromOutsideAreReadable) {
  const auto text = [](std::string_view content) {
    return draw_png(300, 40, [&](Canvas& canvas) { canvas.text({5, 25}, content, {}); }).value();
  };
  EXPECT_EQ(text("Straße"), text("Strasse"));
  EXPECT_EQ(text("ロボ\n\xFF"), text("????"));
  EXPECT_EQ(text(""), text(std::string(1, ' ')));
  EXPECT_NE(text("?"), text(""));
}

TEST(RasterCanvas, NonsenseBreaksNothing) {
  const cv::Mat picture = drawn(50, 50, [](Canvas& canvas) {
    for (const double x : {kNan, double{INFINITY}, -double{INFINITY}, 1e300, -1e300, 2e9, -2e9}) {
      canvas.line({x, x}, {0, x}, {.width = 2});
      canvas.lines(std::vector<Spot>{{x, 0}, {1, x}, {-x, 5}}, {.dashes = "1 1"});
      canvas.lines({}, {});
      canvas.frame({x, 0, x, x}, {});
      canvas.area({0, x, 5, x}, "#123456");
      canvas.cells(std::vector<CellRun>{{2147483647, -2147483647, 2147483647}}, {x, 0}, x, "");
      canvas.dot({x, x}, 5, "#00000g", x);
      canvas.text({x, x}, "text", {});
      canvas.text({5, 5}, std::string(1'000'000, 'W'), {.anchor = Anchor::kEnd});
      canvas.clip({x, 0, x, x});
      canvas.dot({5, 5}, 5, "#000000", 1);
      canvas.end_clip();
    }
  });
  EXPECT_EQ(picture.size(), cv::Size(50, 50));
}

// At, below and above the limits; nothing is drawn on a picture that is too large.
TEST(RasterCanvas, ItsSizeIsLimited) {
  int calls = 0;
  const auto size = [&](double width, double height) {
    return draw_png(width, height, [&](Canvas&) { ++calls; });
  };
  EXPECT_TRUE(size(kRasterSideMax, 1));
  EXPECT_TRUE(size(1000, static_cast<double>(kRasterPixelsMax) / 1000));
  EXPECT_EQ(calls, 2);
  for (const auto& [width, height] :
       {std::pair(kRasterSideMax + 1.0, 1.0), std::pair(1.0, kRasterSideMax + 0.5),
        std::pair(1001.0, static_cast<double>(kRasterPixelsMax) / 1000), std::pair(1e300, 1.0)}) {
    const auto png = size(width, height);
    ASSERT_FALSE(png) << width << " x " << height;
    EXPECT_EQ(png.error().code(), tims::Errc::kTooBig);
    EXPECT_THAT(png.error().detail(), HasSubstr("fewer curves"));
  }
  for (const auto& [width, height] :
       {std::pair(0.0, 1.0), std::pair(1.0, -1.0), std::pair(kNan, 1.0), std::pair(1.0, kNan)})
    EXPECT_EQ(size(width, height).error().code(), tims::Errc::kInvalidArgument);
  EXPECT_EQ(calls, 2);
}

}  // namespace raster_canvas_test
}  // namespace rack::pictures
