#include "router/policy/types.h"

#include <gtest/gtest.h>

namespace tims::policy::types_test {

constexpr Address kChassis{0x03110000};
constexpr Address kPilot{0x03180000};
constexpr Address kRouter{0x03000100};

bool matches(std::string_view pattern, const Query& query) {
  const auto parsed = TypePattern::parse(pattern);
  EXPECT_TRUE(parsed) << pattern;
  return parsed && parsed->matches(query, query.class_id({}));
}
Query message(std::int8_t type, Address dest, Address src = kPilot) {
  return {.dest = dest, .src = src, .type = type};
}
Query asks(Right right) {
  return {.dest = kRouter, .src = kPilot, .type = type::kAdminRequest, .right = right};
}

TEST(Types, NamesNumbersAndRanges) {
  EXPECT_TRUE(matches("chassis.move", message(21, kChassis)));
  EXPECT_FALSE(matches("chassis.move", message(21, kPilot)));
  EXPECT_TRUE(matches("Chassis.Move", message(21, kChassis)));
  EXPECT_TRUE(matches("on", message(type::kOn, kPilot)));
  EXPECT_TRUE(matches("-6", message(type::kData, kChassis)));
  EXPECT_TRUE(matches("20..22", message(22, kPilot)));
  EXPECT_FALSE(matches("20..22", message(23, kPilot)));
  EXPECT_TRUE(matches("-128..127", message(-128, kPilot)));
  for (const char* text : {"", "chassis", "chassis.", "128", "5..4", "1..", "mov", "look, drive"})
    EXPECT_FALSE(TypePattern::parse(text)) << text;
}

// Data and answers are of the class of their sender.
TEST(Types, ADataNameIsOfTheSender) {
  EXPECT_TRUE(matches("chassis.data", message(type::kData, kPilot, kChassis)));
  EXPECT_FALSE(matches("chassis.data", message(type::kData, kChassis, kPilot)));
}

TEST(Types, WordsAreSets) {
  EXPECT_TRUE(matches("commands", message(1, kPilot)));
  EXPECT_FALSE(matches("commands", message(0, kPilot)));
  EXPECT_TRUE(matches("replies", message(0, kPilot)));
  EXPECT_TRUE(matches("drive", message(21, kChassis)));
  EXPECT_FALSE(matches("drive", message(type::kOff, kChassis))) << "stopping is no driving";
  EXPECT_TRUE(matches("look", message(type::kGetContData, kChassis)));
  EXPECT_FALSE(matches("look", message(type::kSetParam, kChassis)));
}

TEST(Types, QuestionsToRoutersAreMetByTheirRightOnly) {
  for (const auto& [word, right] :
       {std::pair("look", Right::kLook), std::pair("change", Right::kChange),
        std::pair("login", Right::kLogin), std::pair("trace", Right::kTrace),
        std::pair("agree", Right::kAgree), std::pair("drive", Right::kDrive)}) {
    EXPECT_TRUE(matches(word, asks(right))) << word;
    EXPECT_TRUE(matches("*", asks(right))) << word;
    EXPECT_FALSE(matches("commands", asks(right))) << word;
    EXPECT_FALSE(matches("64", asks(right))) << word;
  }
  EXPECT_FALSE(matches("look", asks(Right::kChange)));
}

TEST(Types, CoversOnlyWhatItMatches) {
  const auto covers = [](std::string_view a, std::string_view b) {
    return TypePattern::parse(a)->covers(*TypePattern::parse(b));
  };
  EXPECT_TRUE(covers("*", "look"));
  EXPECT_TRUE(covers("commands", "chassis.move"));
  EXPECT_FALSE(covers("commands", "look")) << "look is a question to routers, too";
  EXPECT_FALSE(covers("chassis.move", "21"));
}

TEST(Types, OneTypeForATest) {
  EXPECT_EQ(parse_type("move", class_id::kChassis)->type, 21);
  EXPECT_EQ(parse_type("-6", class_id::kChassis)->type, -6);
  EXPECT_EQ(parse_type("login", class_id::kChassis)->right, Right::kLogin);
  EXPECT_FALSE(parse_type("commands", class_id::kChassis));
  EXPECT_FALSE(parse_type("chassis.mov", class_id::kChassis));
}

}  // namespace tims::policy::types_test
