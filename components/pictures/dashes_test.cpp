#include "components/pictures/dashes.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::pictures {
namespace dashes_test {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

constexpr Box kBox{0, 0, 100, 100};

// The dashes as texts: "0,5 7,5".
std::vector<std::string> dashed(const std::vector<Spot>& line, std::vector<double> lengths,
                                const Box& box = kBox) {
  std::vector<std::string> texts;
  for (const auto& dash : dashes_of(line, lengths, box)) {
    std::string text;
    for (const Spot& spot : dash)
      text += (text.empty() ? "" : " ") + std::to_string(std::lround(spot.x)) + "," +
              std::to_string(std::lround(spot.y));
    texts.push_back(text);
  }
  return texts;
}

TEST(DashLengths, AreNumbersOfPixels) {
  EXPECT_THAT(dash_lengths("7 3"), ElementsAre(7, 3));
  EXPECT_THAT(dash_lengths("10 3 2 3"), ElementsAre(10, 3, 2, 3));
  EXPECT_THAT(dash_lengths("0.5 1 2"), ElementsAre(0.5, 1, 2, 0.5, 1, 2)) << "as in SVG";
  for (const char* text : {"", "a", "7  3", "7,3", "-1 3", "0 0", "0.4 1", "nan 1", "inf 1"})
    EXPECT_THAT(dash_lengths(text), IsEmpty()) << text;
}

TEST(Dashes, AreDrawnAndLeftOutInTurns) {
  EXPECT_THAT(dashed({{0, 5}, {20, 5}}, {7, 3}), ElementsAre("0,5 7,5", "10,5 17,5"));
  EXPECT_THAT(dashed({{0, 0}, {0, 18}}, {10, 3, 2, 3}), ElementsAre("0,0 0,10", "0,13 0,15"));
  EXPECT_THAT(dashed({{0, 5}, {6, 5}}, {7, 3}), ElementsAre("0,5 6,5"));
  EXPECT_THAT(dashed({{0, 5}, {20, 5}}, {}), IsEmpty());
  EXPECT_THAT(dashed({{0, 5}}, {7, 3}), IsEmpty());
}

TEST(Dashes, ContinueAroundCorners) {
  EXPECT_THAT(dashed({{0, 0}, {5, 0}, {5, 20}}, {7, 3}),
              ElementsAre("0,0 5,0 5,2", "5,5 5,12", "5,15 5,20"));
  // Many short segments are one line.
  std::vector<Spot> line;
  for (int i = 0; i <= 200; ++i) line.push_back({i * 0.1, 5});
  const auto dashes = dashes_of(line, std::vector<double>{7, 3}, kBox);
  ASSERT_THAT(dashes, SizeIs(testing::Ge(2U)));
  EXPECT_NEAR(dashes[0].back().x, 7, 0.01);
}

TEST(Dashes, OutsideTakeNoTimeAndMoveNothing) {
  const Box box{1000, 0, 19, 10};
  EXPECT_THAT(dashed({{0, 5}, {1e6, 5}}, {7, 3}, box),
              ElementsAre("1000,5 1007,5", "1010,5 1017,5"));
  EXPECT_THAT(dashed({{0, 5}, {990, 5}, {1020, 5}}, {7, 3}, box),
              ElementsAre("1000,5 1007,5", "1010,5 1017,5"));
  EXPECT_THAT(dashed({{0, 50}, {9e6, 50}}, {7, 3}, box), IsEmpty());
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(dashed({{0, 5}, {1e300, 5}}, {7, 3}, box), IsEmpty());
  EXPECT_THAT(dashed({{kNan, 5}, {INFINITY, 5}, {1, kNan}}, {7, 3}, box), IsEmpty());
}

}  // namespace dashes_test
}  // namespace rack::pictures
