#include "router/io/waiting_memory.h"

#include <gtest/gtest.h>

namespace tims::io {
namespace waiting_memory_test {

constexpr std::uint64_t kMi = 1 << 20;
constexpr std::uint64_t kStep = HalfMessages::kStepBytes;

Time at(int ms) { return Time(std::chrono::milliseconds(ms)); }

TEST(HalfMessages, TheBoundHoldsAtLeastTwoMessages) {
  EXPECT_EQ(HalfMessages(1 << 20).bytes_max(), 64 * kMi);
  EXPECT_EQ(HalfMessages(32 << 20).bytes_max(), 64 * kMi);
  EXPECT_EQ(HalfMessages(33 << 20).bytes_max(), 66 * kMi);
}

TEST(HalfMessages, NobodyGoesUpToTheBound) {
  HalfMessages half(16 << 20);
  for (std::uint32_t client = 0; client < 4; ++client) half.set(at(1), client, 16 * kMi);
  for (std::uint32_t client = 4; client < 1000; ++client) half.set(at(1), client, kStep);
  EXPECT_FALSE(half.victim()) << "a little does not count";
  half.set(at(1), 4, kStep + 1);
  EXPECT_TRUE(half.victim());
}

TEST(HalfMessages, TheOneGoesThatHasLongestNotSentOn) {
  HalfMessages half(16 << 20);
  for (std::uint32_t client = 0; client < 4; ++client)
    half.set(at(static_cast<int>(client)), client, 15 * kMi);
  half.set(at(10), 0, 15 * kMi + kStep);
  half.set(at(11), 1, 15 * kMi + kStep - 1);  // too little to count
  half.set(at(12), 7, 15 * kMi);
  EXPECT_EQ(half.victim()->token, 1U);
  half.set(at(12), 1, 0);
  EXPECT_FALSE(half.victim());
  half.set(at(13), 0, kMi);  // the next message
  half.set(at(14), 8, 16 * kMi);
  half.set(at(15), 9, 16 * kMi);
  EXPECT_EQ(half.victim()->token, 2U);
}

TEST(HalfMessages, AClientThatHoldsLittleStays) {
  HalfMessages half(16 << 20);
  half.set(at(0), 1, kMi);
  for (std::uint32_t client = 2; client < 7; ++client) half.set(at(5), client, 15 * kMi);
  EXPECT_EQ(half.victim()->token, 2U);
}

TEST(HalfMessages, WhatIsDoneIsForgotten) {
  HalfMessages half(16 << 20);
  for (int round = 0; round < 100; ++round) {
    half.set(at(round), 1, 16 * kMi);
    half.set(at(round), 1, 0);
    half.set(at(round), 1, 0);
  }
  for (std::uint32_t client = 0; client < 4; ++client) half.set(at(200), client, 16 * kMi);
  EXPECT_FALSE(half.victim());
}

}  // namespace waiting_memory_test
}  // namespace tims::io
