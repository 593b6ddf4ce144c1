#include "rack/codec/fields.h"

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

}  // namespace rack
