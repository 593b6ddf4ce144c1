#include "components/devices/positioning/cmps03.h"

#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/core/test_bytes.h"

namespace rack::device {
namespace cmps03_test {

using namespace std::chrono_literals;

constexpr double kDegree = std::numbers::pi / 180;

class Cmps03Test : public testing::Test {
 protected:
  void receive(Cmps03& compass, std::string_view text) {
    now_ += 10ms;
    const auto bytes = bytes_of_text(text);
    compass.on_arrival({.bytes = bytes, .first = now_, .last = now_}, out_);
  }
  std::optional<CompassData> taken(Cmps03& compass) {
    CompassData data;
    Time recorded;
    if (!compass.take(data, recorded)) return std::nullopt;
    return data;
  }
  // Does the same as the program after each wait.
  Cmps03::Step turn(Cmps03& compass, bool wanted, bool aligned) {
    now_ += 10ms;
    compass.request_calibration(wanted, aligned, now_);
    if (compass.next_timeout() <= now_) compass.on_timeout(now_, out_);
    return compass.take_step(direction_);
  }

  ReceivedOutput out_;
  Time now_{1000s};
  int direction_ = 0;
};

TEST_F(Cmps03Test, Lines) {
  EXPECT_EQ(parse_cmps03("$1234"), 123.4);
  EXPECT_EQ(parse_cmps03("$0000"), 0.0);
  for (const std::string_view line :
       {"", "$", "$123", "$12345", "$12a4", "$-123", "$3601", "1234", "$OK"})
    EXPECT_FALSE(parse_cmps03(line)) << line;
}

TEST_F(Cmps03Test, EverySplitGivesItsHeadings) {
  const auto bytes = bytes_of_text("34\n$0900\r\n$18$2700\nx\n$12b4\n$1800\n");
  for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
    Cmps03 compass({});
    compass.start(now_, out_);
    std::vector<double> found;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const auto piece = std::span(bytes).subspan(i, 1);
      compass.on_arrival({.bytes = piece, .first = now_, .last = now_}, out_);
      if (const auto data = taken(compass)) found.push_back(data->orientation / kDegree);
    }
    ASSERT_EQ(found.size(), 3U);
    EXPECT_NEAR(found[0], 90, 1e-4);
    EXPECT_NEAR(found[1], 270, 1e-4);
  }
}

TEST_F(Cmps03Test, TheOffsetIsAdded) {
  Cmps03 compass({.offset = -30});
  compass.start(now_, out_);
  receive(compass, "$0100\n");
  const auto data = taken(compass);
  ASSERT_TRUE(data);
  EXPECT_NEAR(data->orientation, 340 * kDegree, 1e-5);
  EXPECT_NEAR(data->varOrientation, 3.5 * kDegree, 1e-6);
  EXPECT_TRUE(compass.is_ready());
}

TEST_F(Cmps03Test, IsCalibratedInFourDirections) {
  Cmps03 compass({});
  compass.start(now_, out_);
  receive(compass, "$0100\n");
  (void)taken(compass);
  EXPECT_EQ(turn(compass, false, false), Cmps03::Step::kNone);
  EXPECT_EQ(turn(compass, true, false), Cmps03::Step::kAlign);
  for (int direction = 1; direction <= 4; ++direction) {
    EXPECT_EQ(turn(compass, true, false), Cmps03::Step::kNone);
    EXPECT_EQ(turn(compass, true, true), Cmps03::Step::kNone);
    ASSERT_EQ(out_.sent.back(), std::vector{cmps03::kCalibrate});
    receive(compass, "$0100\n");
    EXPECT_NEAR(taken(compass)->varOrientation, std::numbers::pi, 1e-6);
    EXPECT_FALSE(compass.is_ready());
    receive(compass, "$OK\n");
    ASSERT_EQ(out_.sent.back(), std::vector{cmps03::kConfirm});
    const auto step = compass.take_step(direction_);
    EXPECT_EQ(step, direction == 4 ? Cmps03::Step::kDone : Cmps03::Step::kConfirmed);
    EXPECT_EQ(direction_, direction);
  }
  EXPECT_TRUE(compass.is_ready());
  EXPECT_EQ(out_.sent.size(), 8U);
}

TEST_F(Cmps03Test, ALostConfirmationIsReported) {
  Cmps03 compass({});
  compass.start(now_, out_);
  (void)turn(compass, true, false);
  (void)turn(compass, true, true);
  now_ += 4s;
  compass.on_timeout(now_, out_);
  EXPECT_EQ(compass.take_step(direction_), Cmps03::Step::kSilent);
  EXPECT_EQ(out_.sent.size(), 1U);
  receive(compass, "$OK\n");  // too late
  EXPECT_EQ(out_.sent.size(), 1U);
  (void)turn(compass, true, true);
  receive(compass, "$OK\n");
  EXPECT_EQ(compass.take_step(direction_), Cmps03::Step::kConfirmed);
  EXPECT_EQ(turn(compass, false, false), Cmps03::Step::kEnded);
  EXPECT_FALSE(compass.is_calibrating());
}

TEST_F(Cmps03Test, ErrorsAreReported) {
  for (const auto& [text, expected] :
       {std::pair{"", "sends nothing"}, {"\x01\x02", "not headings"}}) {
    Cmps03 compass({});
    compass.start(now_, out_);
    receive(compass, text);
    compass.on_timeout(now_ + 10s, out_);
    ASSERT_TRUE(compass.failure());
    EXPECT_THAT(compass.failure()->detail(), testing::HasSubstr(expected));
  }
}

TEST_F(Cmps03Test, NoiseBreaksNothing) {
  std::mt19937 random(1);
  Cmps03 compass({});
  compass.start(now_, out_);
  constexpr std::string_view kLikely = "$0123456789OK\n";
  for (int i = 0; i < 20000; ++i) {
    std::string noise(random() % 40, ' ');
    for (char& c : noise)
      c = random() % 4 == 0 ? static_cast<char>(random()) : kLikely[random() % 14];
    receive(compass, noise);
    (void)turn(compass, random() % 8 != 0, random() % 2 == 0);
    if (compass.failure()) compass.start(now_, out_);
    if (const auto data = taken(compass)) {
      EXPECT_LT(data->orientation, 2 * std::numbers::pi + 1e-6);
    }
  }
}

}  // namespace cmps03_test
}  // namespace rack::device
