#include "rack/codec/parse.h"

#include <gtest/gtest.h>

#include "proxies/codec/sample_fixture.h"

namespace rack {
namespace {

using test::Sample;

std::string set(Sample& order, std::string_view field, std::string_view value, bool si = false) {
  const auto done = assign(order, {field, value}, {.si = si});
  return done ? "" : done.error().detail();
}

TEST(Parse, NumbersInTheUnitsOfTheWire) {
  Sample order;
  EXPECT_EQ(set(order, "recordingTime", "7"), "");
  EXPECT_EQ(set(order, "pos.x", "-5"), "");
  EXPECT_EQ(set(order, "pos.rho", "0.5"), "");
  EXPECT_EQ(set(order, "levels[1]", "-128"), "");
  EXPECT_EQ(order.recordingTime, TimeStamp(7));
  EXPECT_EQ(order.pos.x, -5);
  EXPECT_EQ(order.pos.rho, 0.5F);
  EXPECT_EQ(order.levels[1], -128);
}

TEST(Parse, NumbersWithUnitsAndInSi) {
  Sample order;
  EXPECT_EQ(set(order, "pos.x", "200mm"), "");
  EXPECT_EQ(order.pos.x, 200);
  EXPECT_EQ(set(order, "pos.x", "0.25 m"), "");
  EXPECT_EQ(order.pos.x, 250);
  EXPECT_EQ(set(order, "pos.x", "-1.5", true), "");
  EXPECT_EQ(order.pos.x, -1500);
  EXPECT_EQ(set(order, "pos.x", "30mm", true), "");
  EXPECT_EQ(order.pos.x, 30);
  EXPECT_EQ(set(order, "recordingTime", "1.5s"), "");
  EXPECT_EQ(order.recordingTime, TimeStamp(1500));
}

TEST(Parse, TextsAddressesBytes) {
  Sample order;
  EXPECT_EQ(set(order, "name", "1234567"), "");
  EXPECT_EQ(order.name, "1234567");
  EXPECT_EQ(set(order, "who", "Pilot(0/1)"), "");
  EXPECT_EQ(order.who, tims::Address(0x00180100));
  EXPECT_EQ(set(order, "who", "none"), "");
  EXPECT_EQ(order.who, kNobody);
  EXPECT_EQ(set(order, "image", "0aff"), "");
  EXPECT_EQ(order.image.size(), 2U);
  EXPECT_EQ(order.image[1], std::byte{255});
}

TEST(Parse, SequencesGrowInTheirOrder) {
  Sample order;
  EXPECT_NE(set(order, "points[1].x", "1"), "");
  EXPECT_EQ(set(order, "points[0].x", "1"), "");
  EXPECT_EQ(set(order, "points[0].rho", "2"), "");
  EXPECT_EQ(set(order, "points[1].x", "3"), "");
  EXPECT_EQ(set(order, "points[2].x", "4"), "");
  EXPECT_NE(set(order, "points[3].x", "5"), "") << "3 fit";
  ASSERT_EQ(order.points.size(), 3U);
  EXPECT_EQ(order.points[0].rho, 2.0F);
  EXPECT_EQ(order.points[1].x, 3);
}

TEST(Parse, RefusesWhatIsNotMeantAndLeavesTheMessageAlone) {
  Sample order{.pos = {.x = 1}, .name = "a", .levels = {3, 4}};
  EXPECT_EQ(set(order, "vz", "1"), "Sample has no field \"vz\"");
  EXPECT_EQ(set(order, "pos.z", "1"), "Pose has no field \"z\"");
  EXPECT_EQ(set(order, "pos.x.y", "1"), "i32 has no field \".y\"");
  EXPECT_EQ(set(order, "pos.x", "fast"), "pos.x=fast: wanted is a number in mm");
  EXPECT_EQ(set(order, "pos.x", ""),
            "pos.x=: wanted is a whole number from -2147483648 to 2147483647");
  EXPECT_EQ(set(order, "pos.x", "1.5"),
            "pos.x=1.5: wanted is a whole number from -2147483648 to 2147483647");
  EXPECT_EQ(set(order, "pos.x", "1rad"), "pos.x=1rad: wanted is a number in mm");
  EXPECT_EQ(set(order, "pos.x", "2147483647"), "");
  EXPECT_EQ(set(order, "pos.x", "2147483648"),
            "pos.x=2147483648: wanted is a whole number from -2147483648 to 2147483647");
  EXPECT_EQ(set(order, "pos.x", "2147484m"),
            "pos.x=2147484m: wanted is a whole number from -2147483648 to 2147483647");
  EXPECT_EQ(set(order, "levels[0]", "128"),
            "levels[0]=128: wanted is a whole number from -128 to 127");
  EXPECT_NE(set(order, "levels[2]", "1"), "");
  EXPECT_NE(set(order, "levels", "1"), "");
  EXPECT_NE(set(order, "pos", "1"), "");
  EXPECT_NE(set(order, "pointNum", "1"), "");
  EXPECT_NE(set(order, "points[0].z", "1"), "");
  EXPECT_NE(set(order, "name", "12345678"), "") << "7 fit";
  EXPECT_NE(set(order, "who", "somebody"), "");
  EXPECT_NE(set(order, "image", "0"), "");
  EXPECT_NE(set(order, "image", "0102030405"), "") << "4 fit";
  EXPECT_NE(set(order, "", "1"), "");
  EXPECT_NE(set(order, "[", "1"), "");
  EXPECT_EQ(order.pos.x, 2147483647);
  EXPECT_EQ(order.name, "a");
  EXPECT_EQ(order.levels[0], 3);
  EXPECT_TRUE(order.points.empty());
}

TEST(Parse, WhatIsPrintedCanBeRead) {
  Sample order{.recordingTime = 1, .pos = {.x = 2, .rho = 0.1F}, .levels = {5, 6}};
  Sample again;
  for (const std::string_view field : {"pos.x", "pos.rho"}) {
    const std::string text = to_text(order, {.si = true});
    const std::size_t at = text.find(std::string(field) + ": ") + field.size() + 2;
    EXPECT_EQ(set(again, field, text.substr(at, text.find('\n', at) - at)), "");
  }
  EXPECT_EQ(again.pos.x, order.pos.x);
  EXPECT_EQ(again.pos.rho, order.pos.rho);
}

}  // namespace
}  // namespace rack
