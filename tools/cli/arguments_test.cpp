#include "tools/cli/arguments.h"

#include <gtest/gtest.h>

namespace timsctl {
namespace arguments_test {

TEST(Arguments, TypesByNumberAndName) {
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

TEST(Arguments, AddressesThatAShellLeavesAlone) {
  EXPECT_EQ(parse_address("Ladar/3/0")->raw(), 0x03140000U);
  EXPECT_EQ(parse_address("ladar/3/0:2")->raw(), 0x03140002U);
  EXPECT_EQ(parse_address("Ladar(3/0)")->raw(), 0x03140000U);
  EXPECT_EQ(parse_address("0x03140000")->raw(), 0x03140000U);
  for (const char* bad : {"", "Ladar", "Ladar/3", "Ladar/3/x", "Ladar/300/0", "Ladar/*/0", "/3/0"})
    EXPECT_FALSE(parse_address(bad)) << bad;
  for (const std::uint32_t raw : {0x03140000U, 0x03140002U, 0x03FF0100U})
    EXPECT_EQ(parse_address(shell_name(tims::Address(raw)))->raw(), raw);
}

TEST(Arguments, Patterns) {
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

}  // namespace arguments_test
}  // namespace timsctl
