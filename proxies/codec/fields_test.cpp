#include "rack/codec/fields.h"

#include <string>

#include <gtest/gtest.h>

namespace rack {

namespace fields_test {

TEST(Sequence, IsAVectorThatKnowsItsBound) {
  Sequence<int, 3> sequence = {1, 2};
  sequence.push_back(3);
  EXPECT_EQ(sequence.size(), 3U);
  static_assert(decltype(sequence)::kMax == 3);
}

TEST(Sequence, ReservedOnceNeverAllocatesAgain) {
  Sequence<int, 100> sequence;
  sequence.reserve_all();
  const int* place = sequence.data();
  for (int i = 0; i < 100; ++i) sequence.push_back(i);
  sequence.clear();
  sequence.resize(100);
  EXPECT_EQ(sequence.data(), place);
}

TEST(Tail, LikeASequence) {
  Tail<int, 100> tail;
  tail.reserve_all();
  EXPECT_GE(tail.capacity(), 100U);
}

}  // namespace fields_test

namespace fields_test {

TEST(Text, HoldsALiteral) {
  const Text<8> text = "ladar_0";
  EXPECT_EQ(text.view(), "ladar_0");
  EXPECT_EQ(text, "ladar_0");
  EXPECT_EQ(text.bytes().back(), '\0');
}

TEST(Text, SaysWhenOnlyTheBeginningFitted) {
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

}  // namespace fields_test

}  // namespace rack
