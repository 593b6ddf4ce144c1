#include "router/io/net/debounce.h"

#include <gtest/gtest.h>

namespace tims::io {
namespace {

using std::chrono::milliseconds;

constexpr Time kStart{std::chrono::seconds(100)};

TEST(Debounce, NothingIsDueWithoutAChange) { EXPECT_EQ(Debounce().due(), kNever); }

TEST(Debounce, IsDueWhenChangesHaveEnded) {
  Debounce debounce;
  debounce.on_change(kStart);
  EXPECT_EQ(debounce.due(), kStart + milliseconds(50));
  debounce.on_change(kStart + milliseconds(30));
  EXPECT_EQ(debounce.due(), kStart + milliseconds(80));
}

TEST(Debounce, ChangesWithoutEndDoNotPutItOffForEver) {
  Debounce debounce;
  for (int ms = 0; ms < 300; ms += 20) debounce.on_change(kStart + milliseconds(ms));
  EXPECT_EQ(debounce.due(), kStart + milliseconds(300));
}

TEST(Debounce, BeginsAnewAfterReset) {
  Debounce debounce;
  debounce.on_change(kStart);
  debounce.reset();
  EXPECT_EQ(debounce.due(), kNever);
  debounce.on_change(kStart + milliseconds(500));
  EXPECT_EQ(debounce.due(), kStart + milliseconds(550));
}

}  // namespace
}  // namespace tims::io
