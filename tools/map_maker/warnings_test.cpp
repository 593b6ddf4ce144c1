// What a user is told about the errors of a map.
#include "tools/map_maker/warnings.h"

#include <gtest/gtest.h>

namespace rack::map_maker {

namespace warnings_test {

mapping::MadeMap good() {
  mapping::MadeMap made;
  made.map.resolution = 50;
  made.loops = 100;
  made.removed = 9;
  made.uncertain = 500;
  made.doubts = {.compared = 200000, .distance = 4000, .places = {{0, 0}}};
  return made;
}

std::string only_warning(const mapping::MadeMap& made) {
  const auto all = warnings(made, {}, "map-doubts.png");
  EXPECT_EQ(all.size(), 1U);
  return all.empty() ? "" : all.front();
}

TEST(MapWarnings, ThereAreNoneAtTheLimits) {
  EXPECT_TRUE(warnings(good(), {}, "").empty());
  auto made = good();
  made.loops = 0;
  EXPECT_TRUE(warnings(made, {}, "").empty()) << "nine loops that were wrong are few";
  made.doubts = {};
  EXPECT_FALSE(contradicts_itself(made));
}

TEST(MapWarnings, AMapThatIsBentEvenlyIsUncertain) {
  auto made = good();
  made.uncertain = 2400;
  made.without_loop = {.distance = 120000, .begin = {1000, 0}, .end = {0, -5000}};
  const std::string text = only_warning(made);
  EXPECT_NE(text.find("errors of about 2.4 m"), std::string::npos) << text;
  EXPECT_NE(text.find("120 m from x 0.0, y 1.0 to x -5.0, y 0.0"), std::string::npos) << text;
}

TEST(MapWarnings, LongDrivesMayBeLessCertain) {
  auto made = good();
  made.distance = 1'900'000;
  made.uncertain = 1900;
  EXPECT_TRUE(warnings(made, {}, "").empty());
  made.uncertain = 1901;
  EXPECT_FALSE(only_warning(made).empty());
}

TEST(MapWarnings, LoopsThatContradictEachOtherAreReported) {
  auto made = good();
  made.removed = 50;
  EXPECT_NE(only_warning(made).find("50 of 150 places"), std::string::npos);
}

TEST(MapWarnings, WallsThatAreSeenThroughAndLargerCellsAreReported) {
  auto made = good();
  made.doubts.distance = 4001;
  EXPECT_TRUE(contradicts_itself(made));
  EXPECT_NE(only_warning(made).find("map-doubts.png"), std::string::npos);
  made = good();
  made.map.resolution = 70;
  EXPECT_NE(only_warning(made).find("cells of 70 mm"), std::string::npos);
}

}  // namespace warnings_test

}  // namespace rack::map_maker
