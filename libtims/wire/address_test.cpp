#include "tims/address.h"

#include <array>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace tims {
namespace address_test {

constexpr AddressWidths kWideInstances{.system = 6, .class_id = 6, .instance = 12, .local = 8};

TEST(Address, FieldsLieMostSignificantFirst) {
  const Address a = Address::of({.system = 3, .class_id = 0x14, .instance = 7, .local = 2});
  EXPECT_EQ(a.raw(), 0x03140702U);
  EXPECT_EQ(a.fields().system, 3U);
  EXPECT_EQ(a.fields().class_id, 0x14U);
  EXPECT_EQ(a.fields().instance, 7U);
  EXPECT_EQ(a.fields().local, 2U);
}

TEST(Address, FieldsAreCutToTheirWidth) {
  EXPECT_EQ(Address::of({.system = 0x101, .class_id = 0, .instance = 0x1FF, .local = 0}).raw(),
            0x0100FF00U);
}

TEST(Address, PrintsAsTheOriginalGuiDoes) {
  EXPECT_EQ(Address(0x00180100).to_string(), "Pilot(0/1)");
  EXPECT_EQ(Address(0x00180101).to_string(), "Pilot(0/1):1");
  EXPECT_EQ(Address(0x80110000).to_string(), "Chassis(128/0)");
  EXPECT_EQ(Address(0x00FF0200).to_string(), "unknown[ff](0/2)");
  EXPECT_EQ(Address(0x00012000).to_string(), "GDOS(0/32)");
  EXPECT_EQ(Address(0).to_string(), "Tims(0/0)");
  EXPECT_EQ(Address(0xFFFFFFFF).to_string(), "unknown[ff](255/255):255");
  EXPECT_EQ(Address(0x000F0003).to_string(), "Tool(0/0):3");
}

TEST(Address, PrintsIntoGivenRoom) {
  std::array<char, 24> room{};
  for (const std::uint32_t raw : {0U, 0x00180101U, 0x00FF0200U, 0xFFFFFFFFU}) {
    EXPECT_EQ(Address(raw).write_to(room), Address(raw).to_string());
    EXPECT_EQ(Address(raw).write_to(room, kWideInstances), Address(raw).to_string(kWideInstances));
  }
  const Address pilot(0x00180101);
  EXPECT_EQ(pilot.write_to(std::span(room).first(12)), "Pilot(0/1):1");
  EXPECT_EQ(pilot.write_to(std::span(room).first(11)), "Pilot(0/1):");
  EXPECT_EQ(pilot.write_to(std::span(room).first(0)), "");
}

TEST(Address, PrintsHexWithAllDigits) {
  EXPECT_EQ(Address(0x03140002).to_hex(), "0x03140002");
  EXPECT_EQ(Address(0).to_hex(), "0x00000000");
  EXPECT_EQ(Address(0xFFFFFFFF).to_hex(), "0xffffffff");
}

TEST(Address, ParsesBothTextFormsAndDecimal) {
  const Address ladar(0x03140002);
  EXPECT_EQ(Address::parse("Ladar(3/0):2"), ladar);
  EXPECT_EQ(Address::parse("LADAR(3/0):2"), ladar);
  EXPECT_EQ(Address::parse("lAdAr(3/0):2"), ladar);
  EXPECT_EQ(Address::parse("0x03140002"), ladar);
  EXPECT_EQ(Address::parse("0X3140002"), ladar);
  EXPECT_EQ(Address::parse("51642370"), ladar);
  EXPECT_EQ(Address::parse("Ladar(3/0)"), Address(0x03140000));
  EXPECT_EQ(Address::parse("unknown[fF](0/2)"), Address(0x00FF0200));
  EXPECT_EQ(Address::parse("0"), Address(0));
  EXPECT_EQ(Address::parse("4294967295"), Address(0xFFFFFFFF));
}

TEST(Address, RefusesEverythingElse) {
  for (const char* text : {"",
                           "Ladar",
                           "Ladar(",
                           "Ladar()",
                           "Ladar(3)",
                           "Ladar(3/)",
                           "Ladar(/0)",
                           "Ladar(3/0",
                           "Ladar(3/0)x",
                           "Ladar(3/0):",
                           "Ladar(3/0):x",
                           "Ladar(3/0) ",
                           " Ladar(3/0)",
                           "Lader(3/0)",
                           "(3/0)",
                           "Ladar(256/0)",
                           "Ladar(3/256)",
                           "Ladar(3/0):256",
                           "Ladar(-1/0)",
                           "Ladar(+1/0)",
                           "Ladar(3/0/0)",
                           "Ladar(0x3/0)",
                           "0x",
                           "0x100000000",
                           "4294967296",
                           "-1",
                           "0x0314000g",
                           "unknown[](0/0)",
                           "unknown[100](0/0)",
                           "unknown[ff(0/0)",
                           "unknown[",
                           "*",
                           "*(3/0)",
                           "Ladar(*/0)",
                           "Ladar(3/*)",
                           "Ladar(3/0):*"}) {
    EXPECT_FALSE(Address::parse(text)) << '"' << text << '"';
  }
  EXPECT_FALSE(Address::parse(std::string_view("Ladar(3/0)\0", 11)));
}

TEST(Address, EveryPrintedFormIsReadBack) {
  std::mt19937 random(2);
  const AddressWidths widths[] = {{}, kWideInstances, {1, 29, 1, 1}, {29, 1, 1, 1}, {4, 8, 4, 16}};
  for (const AddressWidths& w : widths) {
    ASSERT_TRUE(w.valid());
    for (int round = 0; round < 20000; ++round) {
      const Address a(static_cast<std::uint32_t>(random()));
      ASSERT_EQ(Address::parse(a.to_string(w), w), a) << a.to_string(w);
      ASSERT_EQ(Address::parse(a.to_hex(), w), a);
      ASSERT_EQ(Address::parse(std::to_string(a.raw()), w), a);
      ASSERT_EQ(Address::of(a.fields(w), w), a);
    }
  }
}

TEST(Address, OtherWidthsMoveTheFieldsAndTheirLimits) {
  const auto a = Address::parse("Ladar(63/4095):1", kWideInstances);
  ASSERT_TRUE(a);
  EXPECT_EQ(a->raw(), 63U << 26 | 0x14U << 20 | 4095U << 8 | 1U);
  EXPECT_FALSE(Address::parse("Ladar(64/0)", kWideInstances));
  EXPECT_FALSE(Address::parse("Ladar(0/4096)", kWideInstances));
  // Class 0x14 does not fit into four bits.
  EXPECT_FALSE(Address::parse("Ladar(0/0)", {.system = 8, .class_id = 4, .instance = 12}));
}

TEST(ClassName, TableOfTheSpecification) {
  struct Row {
    std::uint32_t id;
    const char* name;
  };
  const Row rows[] = {
      {0x00, "Tims"},       {0x01, "GDOS"},    {0x02, "GUI"},      {0x0F, "Tool"},
      {0x10, "Test"},       {0x11, "Chassis"}, {0x12, "Odometry"}, {0x13, "Position"},
      {0x14, "Ladar"},      {0x15, "Camera"},  {0x16, "Gps"},      {0x17, "Joystick"},
      {0x18, "Pilot"},      {0x19, "Scan2d"},  {0x1A, "Datalog"},  {0x1B, "ObjRecog"},
      {0x1C, "Clock"},      {0x1D, "Vehicle"}, {0x1E, "Gyro"},     {0x1F, "Io"},
      {0x20, "ServoDrive"}, {0x21, "Scan3d"},  {0x22, "Planner"},  {0x23, "FeatureMap"},
      {0x24, "GridMap"},    {0x25, "Path"},    {0x26, "Mcl"},      {0x27, "PtzDrive"},
      {0x28, "Compass"},    {0x7F, "World"},
  };
  std::size_t named = 0;
  for (std::uint32_t id = 0; id < 256; ++id) named += class_name(id).empty() ? 0 : 1;
  EXPECT_EQ(named, std::size(rows));
  for (const Row& row : rows) {
    EXPECT_EQ(class_name(row.id), row.name);
    EXPECT_EQ(class_id_of(row.name), row.id);
  }
  EXPECT_EQ(class_id_of("ladar"), class_id::kLadar);
  EXPECT_FALSE(class_id_of(""));
  EXPECT_FALSE(class_id_of("Lada"));
  EXPECT_FALSE(class_id_of("Ladar2"));
}

struct PatternCase {
  const char* pattern;
  std::vector<const char*> matching;
  std::vector<const char*> others;
};

TEST(AddressPattern, Globs) {
  const PatternCase cases[] = {
      {"*", {"Ladar(3/0):2", "0x00000000", "0xffffffff"}, {}},
      {"Ladar(*/*)", {"Ladar(3/0)", "Ladar(255/7):9"}, {"Pilot(3/0)"}},
      {"*(3/0)", {"Ladar(3/0)", "Pilot(3/0):5"}, {"Ladar(3/1)", "Ladar(2/0)"}},
      {"*(3/*)", {"Ladar(3/0)", "Pilot(3/9):5"}, {"Ladar(2/0)"}},
      {"*(*/*):2", {"Ladar(3/0):2", "Tims(0/0):2"}, {"Ladar(3/0)", "Ladar(3/0):3"}},
      {"Ladar(3/0)", {"Ladar(3/0)", "Ladar(3/0):2"}, {"Ladar(3/1)", "Pilot(3/0)"}},
      {"Ladar(3/0):*", {"Ladar(3/0)", "Ladar(3/0):2"}, {"Ladar(3/1)"}},
      {"ladar(3/0):0", {"Ladar(3/0)"}, {"Ladar(3/0):2"}},
      {"unknown[ff](*/2)", {"0x00ff0200", "0x07ff0201"}, {"0x00ff0100", "0x00fe0200"}},
      {"0x03140002", {"Ladar(3/0):2"}, {"Ladar(3/0)"}},
      {"51642370", {"Ladar(3/0):2"}, {"Ladar(3/0)"}},
  };
  for (const PatternCase& c : cases) {
    const auto pattern = AddressPattern::parse(c.pattern);
    ASSERT_TRUE(pattern) << c.pattern;
    for (const char* a : c.matching) {
      EXPECT_TRUE(pattern->matches(*Address::parse(a))) << c.pattern << " and " << a;
    }
    for (const char* a : c.others) {
      EXPECT_FALSE(pattern->matches(*Address::parse(a))) << c.pattern << " and " << a;
    }
  }
}

TEST(AddressPattern, DefaultMatchesEverything) {
  EXPECT_TRUE(AddressPattern().matches(Address(0)));
  EXPECT_TRUE(AddressPattern().matches(Address(0xFFFFFFFF)));
}

TEST(AddressPattern, RefusesWhatIsNoPattern) {
  for (const char* text : {"", "**", "*(3)", "*()", "Lad*(3/0)", "*(3/0):", "*(3*/0)", "0x*", "*:2",
                           "Ladar(256/*)", "*(*/*):256"}) {
    EXPECT_FALSE(AddressPattern::parse(text)) << '"' << text << '"';
  }
}

TEST(AddressPattern, FollowsOtherWidths) {
  const auto pattern = AddressPattern::parse("Ladar(*/4095)", kWideInstances);
  ASSERT_TRUE(pattern);
  EXPECT_TRUE(pattern->matches(*Address::parse("Ladar(7/4095):3", kWideInstances)));
  EXPECT_FALSE(pattern->matches(*Address::parse("Ladar(7/4094):3", kWideInstances)));
}

TEST(Address, StatesWhyATextIsNone) {
  EXPECT_EQ(Address::problem("Lader(3/0)"), "no class is called Lader");
  EXPECT_EQ(Address::problem("Ladar(256/0)"),
            "system 256 is out of range: 0 to 255 with the address widths of this fleet");
  EXPECT_EQ(Address::problem("Ladar(3/4096)", kWideInstances),
            "instance 4096 is out of range: 0 to 4095 with the address widths of this fleet");
  EXPECT_EQ(Address::problem("Ladar(3/0):999"),
            "local id 999 is out of range: 0 to 255 with the address widths of this fleet");
  EXPECT_EQ(Address::problem("unknown[100](0/0)"),
            "class 256 is out of range: 0 to 255 with the address widths of this fleet");
  for (const char* text : {"", "Ladar", "Ladar(3/0", "Ladar(x/0)", "(0/0)"})
    EXPECT_EQ(Address::problem(text), "") << text;
  for (const char* text : {"Ladar(3/0)", "Ladar(*/0)"})
    EXPECT_EQ(Address::problem(text), "") << text;
}

TEST(Address, TextsHaveTheirSinkInEveryFleet) {
  EXPECT_EQ(text_sink(), Address(0x00010000));
  for (const AddressWidths w : {AddressWidths{12, 8, 6, 6}, {6, 8, 10, 8}, {16, 8, 4, 4}})
    EXPECT_EQ(text_sink(w).to_string(w), "GDOS(0/0)");
}

// Last test, because a registered name cannot be removed.
TEST(AddressNames, ClassesOfOthersAreNamed) {
  EXPECT_EQ(Address(0x00800000).to_string(), "unknown[80](0/0)");
  EXPECT_FALSE(name_class(0x14, "Radar")) << "that is Ladar's number";
  EXPECT_FALSE(name_class(0x80, "ladar")) << "that is Ladar's name";
  EXPECT_TRUE(name_class(0x80, "Thermometer"));
  EXPECT_FALSE(name_class(0x81, "thermometer"));
  EXPECT_EQ(Address(0x00800000).to_string(), "Thermometer(0/0)");
  EXPECT_EQ(Address::parse("thermometer(0/0)"), Address(0x00800000));
  EXPECT_EQ(Address::parse("unknown[80](0/0)"), Address(0x00800000));
  static std::array<std::string, 64> names;
  for (std::uint32_t i = 0; i < names.size(); ++i) {
    names[i] = "own" + std::to_string(i);
    EXPECT_EQ(name_class(0x81 + i, names[i]), i < names.size() - 1);
  }
}

}  // namespace address_test
}  // namespace tims
