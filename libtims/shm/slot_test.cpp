#include "shm/slot.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace tims::shm {

namespace slot_test {

constexpr std::uint32_t kMax24 = SlotWord::kMask24;

TEST(SlotWord, EveryFieldKeepsToItsBits) {
  for (const SlotWord& word :
       {SlotWord{SlotState::kAbandoned, 0, 0, 0}, SlotWord{SlotState::kFree, 255, 0, 0},
        SlotWord{SlotState::kFree, 0, kMax24, 0}, SlotWord{SlotState::kFree, 0, 0, kMax24}})
    EXPECT_EQ(SlotWord::unpack(word.pack()), word);
  EXPECT_EQ((SlotWord{SlotState::kWriting, 0xAB, 0x123456, 0x789ABC}.pack()), 0x789ABC123456AB01);
  EXPECT_EQ(SlotWord::unpack(0), SlotWord{}) << "zeroed memory is free";
}

TEST(SlotWord, ALife) {
  const SlotWord writing = SlotWord{.generation = 7}.claimed_by(42, 9);
  EXPECT_EQ(writing, (SlotWord{SlotState::kWriting, 9, 42, 8}));
  EXPECT_EQ(writing.committed(), (SlotWord{SlotState::kReadable, 9, 0, 8}));
  EXPECT_EQ(writing.committed().locked(), (SlotWord{SlotState::kLocked, 0, 0, 8}));
  EXPECT_EQ(writing.abandoned(), (SlotWord{SlotState::kAbandoned, 0, 0, 8}));
  EXPECT_EQ(writing.abandoned().freed(), (SlotWord{SlotState::kFree, 0, 0, 8}));
}

TEST(SlotWord, GenerationsBeginAgain) {
  EXPECT_EQ(SlotWord{.generation = kMax24}.claimed_by(1, 0).generation, 0U);
}

TEST(Hint, EveryFieldKeepsToItsBits) {
  const Hint hint = Hint::unpack(Hint{0xFEDC, 0xABCDEF, 0x12, 0x3456}.pack());
  EXPECT_EQ(hint.lap, 0xFEDC);
  EXPECT_EQ(hint.generation, 0xABCDEFU);
  EXPECT_EQ(hint.priority, 0x12);
  EXPECT_EQ(hint.index, 0x3456);
}

TEST(Stamp, AgeCountsBothParts) {
  const Stamp now{100, 10};
  EXPECT_EQ((Stamp{90, 8}.age(now)), 12U);
  EXPECT_EQ(now.age(now), 0U);
  EXPECT_GT((Stamp{90, 8}.age(now)), (Stamp{91, 8}.age(now)));
}

TEST(Stamp, LaterThanNowIsNotOld) {
  const Stamp now{100, 10};
  EXPECT_EQ((Stamp{101, 10}.age(now)), 0U);
  EXPECT_TRUE((Stamp{100, 10}.not_after(now)));
  EXPECT_FALSE((Stamp{101, 9}.not_after(now)));
  EXPECT_FALSE((Stamp{99, 11}.not_after(now)));
}

TEST(Stamp, BothPartsMayWrap) {
  const Stamp before{0xFFFFFFF0, 0xFFFFFFFF};
  const Stamp now{0x10, 0};
  EXPECT_TRUE(before.not_after(now));
  EXPECT_FALSE(now.not_after(before));
  EXPECT_EQ(before.age(now), 0x21U);
  EXPECT_EQ(Stamp::unpack(before.pack()).age(now), 0x21U);
}

TEST(PriorityIndex, AgreesWithAStableSort) {
  std::mt19937 random(1);
  for (int round = 0; round < 200; ++round) {
    PriorityIndex index(64);
    std::vector<Hint> model;
    for (std::uint32_t i = 0; i < 64; ++i) {
      const Hint hint{.generation = i,
                      .priority = static_cast<std::uint8_t>(random() % (round + 1))};
      index.put(hint);
      model.push_back(hint);
    }
    EXPECT_TRUE(index.full());
    std::stable_sort(model.begin(), model.end(),
                     [](Hint a, Hint b) { return a.priority > b.priority; });
    for (const Hint& expected : model) {
      EXPECT_EQ(index.front().generation, expected.generation);
      index.pop();
    }
    EXPECT_TRUE(index.empty());
  }
}

TEST(PriorityIndex, PutBackGoesInFrontOfItsEquals) {
  PriorityIndex index(4);
  index.put({.generation = 1, .priority = 7});
  index.put_back({.generation = 2, .priority = 7});
  index.put({.generation = 3, .priority = 7});
  for (std::uint32_t expected : {2U, 1U, 3U}) {
    EXPECT_EQ(index.front().generation, expected);
    index.pop();
  }
}

TEST(PriorityIndex, RetainKeepsTheOrder) {
  PriorityIndex index(8);
  for (std::uint32_t i = 0; i < 8; ++i)
    index.put({.generation = i, .priority = static_cast<std::uint8_t>(i % 2)});
  index.retain([](Hint hint) { return hint.generation >= 4; });
  for (std::uint32_t expected : {5U, 7U, 4U, 6U}) {
    EXPECT_EQ(index.front().generation, expected);
    index.pop();
  }
  EXPECT_TRUE(index.empty());
}

}  // namespace slot_test

}  // namespace tims::shm
