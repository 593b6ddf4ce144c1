#include "tools/timsctl/values.h"

#include <gtest/gtest.h>

namespace timsctl {
namespace {

using namespace std::chrono_literals;

TEST(Values, Durations) {
  EXPECT_EQ(parse_duration("250ms"), 250ms);
  EXPECT_EQ(parse_duration("2s"), 2s);
  EXPECT_EQ(parse_duration("1.5"), 1500ms) << "a bare number is seconds";
  EXPECT_EQ(parse_duration("10us"), 10us);
  EXPECT_EQ(parse_duration("2min"), 2min);
  EXPECT_EQ(parse_duration("0"), 0s);
  for (const char* bad : {"", "s", "-1s", "2 s", "2x", "1e400", "nan", "99999999999h", "1.2.3"})
    EXPECT_FALSE(parse_duration(bad)) << bad;
}

TEST(Values, Sizes) {
  EXPECT_EQ(parse_size("64"), 64U);
  EXPECT_EQ(parse_size("4KiB"), 4096U);
  EXPECT_EQ(parse_size("1.5kB"), 1500U);
  for (const char* bad : {"", "4 KiB", "-1", "5GiB", "x"}) EXPECT_FALSE(parse_size(bad)) << bad;
}

TEST(Values, TypesByNumberAndName) {
  EXPECT_EQ(parse_type("-6"), -6);
  EXPECT_EQ(parse_type("127"), 127);
  EXPECT_EQ(parse_type("data"), -6);
  EXPECT_EQ(parse_type("get_status"), 3);
  for (const char* bad : {"", "128", "-129", "6x", "move"}) EXPECT_FALSE(parse_type(bad)) << bad;
  EXPECT_EQ(type_name(-3), "not_available");
  EXPECT_EQ(type_name(42), "");
  EXPECT_EQ(type_name(-6), "data");
  EXPECT_EQ(parse_type("move", tims::class_id::kChassis), 21);
  EXPECT_EQ(parse_type("DATA", tims::class_id::kChassis), -6);
}

TEST(Values, AddressesThatAShellLeavesAlone) {
  EXPECT_EQ(parse_address("Ladar/3/0")->raw(), 0x03140000U);
  EXPECT_EQ(parse_address("ladar/3/0:2")->raw(), 0x03140002U);
  EXPECT_EQ(parse_address("Ladar(3/0)")->raw(), 0x03140000U);
  EXPECT_EQ(parse_address("0x03140000")->raw(), 0x03140000U);
  for (const char* bad : {"", "Ladar", "Ladar/3", "Ladar/3/x", "Ladar/300/0", "Ladar/*/0", "/3/0"})
    EXPECT_FALSE(parse_address(bad)) << bad;
  for (const std::uint32_t raw : {0x03140000U, 0x03140002U, 0x03FF0100U})
    EXPECT_EQ(parse_address(shell_name(tims::Address(raw)))->raw(), raw);
}

TEST(Values, Patterns) {
  const auto matches = [](const char* text, std::uint32_t raw) {
    const auto pattern = parse_pattern(text);
    return pattern && pattern->matches(tims::Address(raw));
  };
  EXPECT_TRUE(matches("Ladar", 0x03140102));
  EXPECT_TRUE(matches("Ladar*", 0x03140102));
  EXPECT_FALSE(matches("Ladar", 0x03150102));
  EXPECT_TRUE(matches("*/3/0", 0x03150000));
  EXPECT_FALSE(matches("*/3/0", 0x03150100));
  EXPECT_TRUE(matches("*", 0xFFFFFFFF));
  EXPECT_FALSE(parse_pattern("Ladarr"));
  EXPECT_FALSE(parse_pattern("Ladar(*"));
}

TEST(Values, HexBothWays) {
  const auto bytes = parse_hex("01 0xff:AB\n00");
  ASSERT_TRUE(bytes);
  EXPECT_EQ(to_hex(*bytes), "01ffab00");
  EXPECT_TRUE(parse_hex("")->empty());
  for (const char* bad : {"0", "0g", "0x", "1 2"}) EXPECT_FALSE(parse_hex(bad)) << bad;
}

}  // namespace
}  // namespace timsctl
