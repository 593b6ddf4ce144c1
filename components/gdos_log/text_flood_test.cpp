#include "components/gdos_log/text_flood.h"

#include <gtest/gtest.h>

namespace rack::gdos_log {
namespace {

using namespace std::chrono_literals;

constexpr tims::Address kChassis(0x00110000);
constexpr tims::Address kLadar(0x00140000);
constexpr tims::Time kStart(1000s);

std::uint32_t passed(TextFlood& flood, tims::Time now, tims::Address sender, gdos::Level level,
                     int texts = 1000) {
  std::uint32_t count = 0;
  for (int i = 0; i < texts; ++i) count += flood.take(now, sender, level) ? 1 : 0;
  return count;
}

TEST(TextFlood, DetailsTakeNoRoomOfErrorsNorOfOthers) {
  TextFlood flood;
  EXPECT_EQ(passed(flood, kStart, kChassis, gdos::Level::kDetail), TextFlood::kOtherBurst);
  EXPECT_FALSE(flood.take(kStart, kChassis, gdos::Level::kInfo));
  EXPECT_EQ(passed(flood, kStart, kChassis, gdos::Level::kError), TextFlood::kUrgentBurst);
  EXPECT_TRUE(flood.take(kStart, kLadar, gdos::Level::kDetail));
  EXPECT_GT(TextFlood::kUrgentBurst, TextFlood::kOtherBurst);
}

TEST(TextFlood, SaysHowManyOnceASecond) {
  TextFlood flood;
  (void)passed(flood, kStart, kChassis, gdos::Level::kDetail, 150);
  EXPECT_TRUE(flood.take_suppressed(kStart + 900ms).empty());
  const auto told = flood.take_suppressed(kStart + 1s);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].sender, kChassis);
  EXPECT_EQ(told[0].count, 50U);
  EXPECT_TRUE(flood.take_suppressed(kStart + 1h).empty());
}

TEST(TextFlood, IsBounded) {
  TextFlood flood;
  // Everybody has said something, and nobody is forgotten yet.
  for (std::uint32_t i = 1; i <= TextFlood::kSendersMax; ++i)
    EXPECT_TRUE(flood.take(kStart, tims::Address(i), gdos::Level::kPrint));
  std::uint32_t of_newcomers = 0;
  for (std::uint32_t i = 0; i < 1000; ++i)
    of_newcomers += flood.take(kStart, tims::Address(i + 5000), gdos::Level::kDetail) ? 1 : 0;
  EXPECT_EQ(of_newcomers, TextFlood::kOtherBurst) << "they share one limit";
  EXPECT_EQ(passed(flood, kStart + 1h, tims::Address(9999), gdos::Level::kDetail),
            TextFlood::kOtherBurst)
      << "those who are silent make room";
}

}  // namespace
}  // namespace rack::gdos_log
