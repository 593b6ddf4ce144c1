#include "components/devices/positioning/dcf77.h"

#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/core/test_bytes.h"

namespace rack::device {
namespace dcf77_test {

using namespace std::chrono_literals;

std::string meinberg(std::string_view text) { return "\x02" + std::string(text) + "\x03"; }

// --- telegrams

TEST(Dcf77Test, AMeinbergTelegramInWinterInSummerAndInUtc) {
  ClockData clock;
  ASSERT_TRUE(parse_meinberg(meinberg("D:23.11.26;T:1;U:12.34.56;    "), clock));
  EXPECT_EQ(clock.hour, 12);
  EXPECT_EQ(clock.minute, 34);
  EXPECT_EQ(clock.second, 56);
  EXPECT_EQ(clock.day, 23);
  EXPECT_EQ(clock.month, 11);
  EXPECT_EQ(clock.year, 2026);
  EXPECT_EQ(clock.dayOfWeek, 1);
  EXPECT_EQ(clock.syncMode, 1);
  EXPECT_EQ(clock.utcTime, 1795433696);
  ASSERT_TRUE(parse_meinberg(meinberg("D:23.11.26;T:1;U:11.34.56;  U "), clock));
  EXPECT_EQ(clock.utcTime, 1795433696);
  ASSERT_TRUE(parse_meinberg(meinberg("D:01.07.26;T:3;U:00.30.00;  S "), clock));
  EXPECT_EQ(clock.utcTime, 1782858600);  // the day before
}

TEST(Dcf77Test, StatusOfAMeinbergClock) {
  ClockData clock;
  for (const auto& [status, mode] :
       {std::pair{"    ", 1}, {"#*  ", 0}, {" *  ", 0}, {"#   ", 0}, {"  S!", 1}, {"   A", 1}}) {
    ASSERT_TRUE(
        parse_meinberg(meinberg("D:23.11.26;T:1;U:12.34.56;" + std::string(status)), clock));
    EXPECT_EQ(clock.syncMode, mode) << status;
  }
}

// Gude's own example, and its checksum.
TEST(Dcf77Test, AnEmcProTelegram) {
  ClockData clock;
  ASSERT_TRUE(parse_emc_pro("<11411604935F0010000000>D4", clock));
  EXPECT_EQ(clock.hour, 11);
  EXPECT_EQ(clock.minute, 41);
  EXPECT_EQ(clock.second, 0);
  EXPECT_EQ(clock.day, 16);
  EXPECT_EQ(clock.month, 4);
  EXPECT_EQ(clock.year, 1993);
  EXPECT_FALSE(parse_emc_pro("<11411604935F0010000000>D5", clock));
  ASSERT_TRUE(parse_emc_pro("<12342311261F0000000056>", clock));
  EXPECT_EQ(clock.syncMode, 1);
  EXPECT_EQ(clock.utcTime, 1795433696);
  ASSERT_TRUE(parse_emc_pro("<13342311261Q0010000056>", clock));
  EXPECT_EQ(clock.syncMode, 0);
  EXPECT_EQ(clock.utcTime, 1795433696);
}

TEST(Dcf77Test, ATimeThatIsNoneIsRefused) {
  ClockData clock;
  for (const std::string_view text :
       {"D:23.11.26;T:1;U:24.00.00;    ", "D:23.11.26;T:1;U:12.60.00;    ",
        "D:23.11.26;T:1;U:12.00.61;    ", "D:29.02.26;T:7;U:12.00.00;    ",
        "D:23.11.26;T:2;U:12.34.56;    ", "D:23.13.26;T:1;U:12.34.56;    ",
        "D:2x.11.26;T:1;U:12.34.56;    ", "D:23.11.26;T:1;U:12.34.56;  X ",
        "D:23.11.26;T:1;U:12.34.56;   ", "D:23.11.26;T:1;U:12:34:56;    "})
    EXPECT_FALSE(parse_meinberg(meinberg(text), clock)) << text;
  EXPECT_TRUE(parse_meinberg(meinberg("D:31.12.16;T:6;U:00.59.60;    "), clock));  // leap second
  for (const std::string_view text : {"<12342311262F0000000056>", "<12342311261F000000005>",
                                      "[12342311261F0000000056>", "<25342311261F0000000056>"})
    EXPECT_FALSE(parse_emc_pro(text, clock)) << text;
}

// --- streams

class Dcf77StreamTest : public testing::TestWithParam<Dcf77Kind> {
 protected:
  std::string telegram(int second) const {
    const std::string two = {static_cast<char>('0' + second / 10),
                             static_cast<char>('0' + second % 10)};
    if (GetParam() == Dcf77Kind::kMeinberg)
      return meinberg("D:23.11.26;T:1;U:12.34." + two + ";    ");
    return "<12342311261F00000000" + two + ">\r";
  }
  int count(Dcf77& clock, std::span<const std::byte> bytes) {
    int found = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      clock.on_arrival({.bytes = bytes.subspan(i, 1), .first = now_, .last = now_ + 1ms}, out_);
      now_ += 1ms;
      ClockData data;
      found += clock.take(data, recorded_) ? 1 : 0;
    }
    return found;
  }

  ReceivedOutput out_;
  Time now_{1000s};
  Time recorded_{};
};

TEST_P(Dcf77StreamTest, JoinsInTheMiddle) {
  const auto bytes = bytes_of_text(telegram(1) + telegram(2) + "noise" + telegram(3));
  const std::size_t first = telegram(1).size();
  for (std::size_t begin = 0; begin < bytes.size(); ++begin) {
    Dcf77 clock(GetParam());
    clock.start(now_, out_);
    const int expected = begin == 0 ? 3 : begin <= first ? 2 : begin <= 2 * first + 5 ? 1 : 0;
    EXPECT_EQ(count(clock, std::span(bytes).subspan(begin)), expected) << begin;
  }
}

TEST_P(Dcf77StreamTest, AFlippedBitBreaksNothing) {
  const auto good = bytes_of_text(telegram(1) + telegram(2));
  for (std::size_t i = 0; i < good.size() * 8; ++i) {
    auto bytes = good;
    bytes[i / 8] ^= static_cast<std::byte>(1 << i % 8);
    Dcf77 clock(GetParam());
    clock.start(now_, out_);
    EXPECT_GE(count(clock, bytes), 1) << i;
  }
}

TEST_P(Dcf77StreamTest, ParityOfSevenBitsDoesNotMatter) {
  auto bytes = bytes_of_text(telegram(1));
  for (std::byte& byte : bytes) byte |= std::byte{0x80};
  Dcf77 clock(GetParam());
  clock.start(now_, out_);
  EXPECT_EQ(count(clock, bytes), 1);
}

TEST_P(Dcf77StreamTest, IsOfTheBeginningOfTheSecond) {
  const auto bytes = bytes_of_text("xxx" + telegram(1));
  Dcf77 clock(GetParam());
  clock.start(now_, out_);
  const Time began = now_;
  ASSERT_EQ(count(clock, bytes), 1);
  if (GetParam() == Dcf77Kind::kMeinberg)
    EXPECT_EQ(recorded_, began + 3ms);
  else
    EXPECT_EQ(recorded_, now_ - 22ms);
}

TEST_P(Dcf77StreamTest, ErrorsAreReported) {
  Dcf77 clock(GetParam());
  clock.start(now_, out_);
  clock.on_timeout(now_ + 6s, out_);
  ASSERT_TRUE(clock.failure());
  EXPECT_THAT(clock.failure()->detail(), testing::HasSubstr("sends nothing"));
  clock.start(now_, out_);
  (void)count(clock, bytes_of_text("hello"));
  clock.on_timeout(now_ + 6s, out_);
  EXPECT_THAT(clock.failure()->detail(), testing::HasSubstr("not telegrams"));
}

TEST_P(Dcf77StreamTest, NoiseBreaksNothing) {
  std::mt19937 random(1);
  Dcf77 clock(GetParam());
  clock.start(now_, out_);
  constexpr std::string_view kLikely = "\x02\x03<>\rD:;.0123456789";
  std::vector<std::byte> noise(200000);
  for (std::byte& byte : noise)
    byte = random() % 4 == 0 ? static_cast<std::byte>(random())
                             : static_cast<std::byte>(kLikely[random() % kLikely.size()]);
  (void)count(clock, noise);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Dcf77StreamTest,
                         testing::Values(Dcf77Kind::kMeinberg, Dcf77Kind::kEmcPro));

}  // namespace dcf77_test
}  // namespace rack::device
