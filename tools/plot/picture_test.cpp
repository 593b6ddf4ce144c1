#include "tools/plot/picture.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/plot/svg.h"

namespace rack::plot {
namespace picture_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t found = 0;
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++found;
  return found;
}

TEST(Ticks, AreRoundNumbers) {
  EXPECT_THAT(ticks(0, 10, 5), ElementsAre(0, 2, 4, 6, 8, 10));
  EXPECT_THAT(ticks(-3, 12, 3), ElementsAre(0, 5, 10));
  EXPECT_THAT(ticks(0.1, 0.38, 5), testing::SizeIs(3));
  EXPECT_THAT(ticks(1, 1, 5), IsEmpty());
  EXPECT_THAT(ticks(kNan, 1, 5), IsEmpty());
  EXPECT_LE(ticks(-1e300, 1e300, 9).size(), 100U);
}

TEST(Svg, LeavesOutWhatNobodySees) {
  Svg svg(100, 100);
  std::vector<Spot> spots;
  for (int i = 0; i <= 1000; ++i) spots.push_back({i * 0.01, 5});
  svg.lines(spots, {});
  const std::string text = std::move(svg).finish();
  EXPECT_THAT(text, HasSubstr("d='M0 5l1 0 1 0 1 0 "));
  EXPECT_LE(text.size(), 600U);
}

TEST(Svg, TextIsEscaped) {
  Svg svg(100, 100);
  svg.text({0, 0}, "a<b> & \"c\"\x1b", {});
  svg.dot({kNan, INFINITY}, 1, "#000000", 1);
  const std::string text = std::move(svg).finish();
  EXPECT_THAT(text, HasSubstr("a&lt;b> &amp; &quot;c&quot;?</text>"));
  EXPECT_THAT(text, Not(HasSubstr("nan")));
  EXPECT_THAT(text, Not(HasSubstr("inf")));
}

TEST(Errors, AreDistancesAtTheSameTime) {
  const Trajectory truth{"truth", Role::kTruth, {0, 10}, {{0, 0}, {1000, 0}}};
  const Trajectory estimate{
      "mcl", Role::kEstimate, {-1, 0, 5, 10, 11}, {{}, {}, {500, 200}, {}, {}}};
  const auto errors = errors_of({truth, estimate});
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_THAT(errors[0].times, ElementsAre(0, 5, 10)) << "empty before the start and after the end";
  EXPECT_THAT(errors[0].values, ElementsAre(0, 0.2, 1));
  EXPECT_EQ(errors[0].unit, "m");
  EXPECT_THAT(errors_of({estimate}), IsEmpty());
  const Trajectory no_times{"truth", Role::kTruth, {}, {{0, 0}}};
  EXPECT_THAT(errors_of({no_times, estimate}), IsEmpty());
}

localisation::GridMap room() {
  localisation::GridMap map{.resolution = 100, .origin = {-500, -500}, .rows = 10, .columns = 20};
  map.cells.assign(200, localisation::Cell::kFree);
  for (std::size_t i = 0; i < 20; ++i) map.cells[i] = localisation::Cell::kOccupied;
  return map;
}

TEST(Picture, NorthIsUpAndEastIsRight) {
  Picture picture;
  picture.trajectories.push_back({"north", Role::kEstimate, {}, {{0, 0}, {10000, 0}}});
  picture.trajectories.push_back({"east", Role::kOdometry, {}, {{0, 0}, {0, 10000}}});
  const std::string text = to_svg(picture);
  const auto ends = [&](const std::string& colour) {
    const auto at = text.rfind("<path d='M", text.rfind(colour));
    double x = 0;
    double y = 0;
    EXPECT_EQ(std::sscanf(text.c_str() + text.find('l', at), "l%lf%lf", &x, &y), 2);
    return std::pair(x, y);
  };
  const auto [north_x, north_y] = ends("#0072b2");
  const auto [east_x, east_y] = ends("#e69f00");
  EXPECT_GT(east_x, north_x);
  EXPECT_GT(east_y, north_y) << "y of a picture goes down";
  EXPECT_NEAR(east_x - north_x, east_y - north_y, 0.3) << "the same scale";
}

TEST(Picture, HasALegendUnitsAndOneDiagramForEachUnit) {
  Picture picture{.title = "A drive", .map = room()};
  picture.trajectories.push_back({"odometry", Role::kOdometry, {}, {{0, 0}, {300, 900}}});
  picture.marks.push_back({"robot", {.x = 100, .y = 100}});
  picture.dots = {{100, 100}, {110, 100}};
  picture.series.push_back({"position error", "m", Role::kEstimate, {5, 6, 7}, {0.1, 0.2, 0.1}});
  picture.series.push_back({"the other", "m", Role::kEstimate, {5, 6}, {0.3, kNan}});
  picture.series.push_back({"turn", "degrees", Role::kEstimate, {5, 6}, {-1, 2}});
  const std::string text = to_svg(picture);
  for (const char* label :
       {"A drive", "map<", "odometry<", "robot<", "samples<", "x, to the north [m]",
        "position error", "[m]<", "[degrees]<", "time [s]"})
    EXPECT_THAT(text, HasSubstr(label));
  EXPECT_EQ(count(text, "time [s]"), 2U);
  EXPECT_THAT(text, HasSubstr("M0 .5m0 9h20")) << "the wall in the south is the lowest row";
  EXPECT_THAT(text, Not(HasSubstr("nan")));
  EXPECT_EQ(count(text, "<g "), count(text, "</g>"));
}

// One drawing, whatever it is drawn on.
TEST(Picture, IsTheSameOnEachCanvas) {
  Picture picture{.title = "A drive", .map = room()};
  picture.trajectories.push_back({"odometry", Role::kOdometry, {}, {{0, 0}, {300, 900}}});
  picture.series.push_back({"turn", "degrees", Role::kEstimate, {5, 6}, {-1, 2}});
  const auto drawn =
      to_png(picture, [](double width, double height, const std::function<void(Canvas&)>& draw,
                         tims::Result<std::string>& png) {
        Svg svg(width, height);
        draw(svg);
        png = std::move(svg).finish();
      });
  ASSERT_TRUE(drawn);
  EXPECT_EQ(*drawn, to_svg(picture));
  const auto refused = to_png(picture, [](double, double, const std::function<void(Canvas&)>&,
                                          tims::Result<std::string>& png) {
    png = tims::Error(tims::Errc::kTooBig, "too large");
  });
  EXPECT_EQ(refused.error().detail(), "too large");
}

TEST(Picture, OfNothingAndOfNonsense) {
  EXPECT_TRUE(Picture{}.empty());
  EXPECT_THAT(to_svg({}), HasSubstr("</svg>"));
  Picture picture;
  picture.trajectories.push_back({"nowhere", Role::kEstimate, {}, {{kNan, 0}, {INFINITY, 3}}});
  picture.trajectories.push_back({"point", Role::kEstimate, {}, {{5, 5}}});
  picture.trajectories.push_back({"far", Role::kEstimate, {}, {{5, 5}, {1e300, -1e300}}});
  picture.series.push_back({"none", "m", Role::kOther, {}, {}});
  const std::string text = to_svg(picture);
  EXPECT_THAT(text, Not(HasSubstr("nan")));
  EXPECT_THAT(text, Not(HasSubstr("inf ")));
}

}  // namespace picture_test
}  // namespace rack::plot
