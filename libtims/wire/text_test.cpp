#include "tims/text.h"

#include <string>

#include <gtest/gtest.h>

namespace tims {
namespace text_test {

TEST(Text, HoldsALiteral) {
  const Text<8> text = "ladar_0";
  EXPECT_EQ(text.view(), "ladar_0");
  EXPECT_EQ(text, "ladar_0");
  EXPECT_EQ(text.bytes().back(), '\0');
}

TEST(Text, ReportsThatOnlyTheBeginningFitted) {
  Text<8> text;
  EXPECT_TRUE(text.assign("1234567"));
  EXPECT_FALSE(text.assign("12345678"));
  EXPECT_EQ(text.view(), "1234567");
}

TEST(Text, EndsAtTheFirstNulAndHidesWhatFollows) {
  Text<8> text = "1234567";
  EXPECT_TRUE(text.assign(std::string("ab\0secret", 9)));
  EXPECT_EQ(text.view(), "ab");
  for (std::size_t i = 2; i < 8; ++i) EXPECT_EQ(text.bytes()[i], '\0');
}

TEST(Text, IsCutWhenItIsTooLong) {
  EXPECT_EQ(Text<6>(std::string_view("abc")).view(), "abc");
  EXPECT_EQ(Text<6>(std::string_view("abcdefg")).view(), "abcde");
  EXPECT_TRUE(Text<6>().empty());
  EXPECT_FALSE(Text<6>("a").empty());
}

}  // namespace text_test
}  // namespace tims
