#include "components/devices/chassis/er1.h"

#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/chassis/er1_robot.h"
#include "rack/devices/virtual_line.h"

namespace rack::device {
namespace er1_test {

using namespace std::chrono_literals;

TEST(Er1Test, ACommandAddsUpToNothing) {
  const auto bytes = Er1Command{.address = 1, .code = Er1Code::kSetVelocity, .value = -2}.encode();
  ASSERT_EQ(bytes.size, 8U);
  unsigned sum = 0;
  for (const std::byte byte : bytes.view()) sum += std::to_integer<unsigned>(byte);
  EXPECT_EQ(sum & 0xFF, 0U);
  EXPECT_EQ(bytes.bytes[3], std::byte{0x11});
  EXPECT_EQ(bytes.bytes[4], std::byte{0xFF});
  EXPECT_EQ(bytes.bytes[7], std::byte{0xFE});
  // Update of axis 0: 00 E6 00 1A.
  EXPECT_EQ(Er1Command{}.encode().bytes[1], std::byte{0xE6});
}

class Er1DialogueTest : public testing::Test {
 protected:
  bool wait_for_data(Er1& dialogue, Duration longest = 3s) {
    bool has = false;
    line_->run(longest, [&] {
      has = has || dialogue.take(data_, recorded_);
      return has || dialogue.failure();
    });
    return has;
  }
  void begin(Er1& dialogue) {
    line_.emplace(dialogue, robot_, emulator::LineSettings{.delay = 1ms});
    line_->start();
    ASSERT_TRUE(wait_for_data(dialogue));
  }

  Er1Emulator robot_;
  std::optional<emulator::VirtualLine> line_;
  ChassisData data_;
  Time recorded_{};
};

TEST_F(Er1DialogueTest, TurnsRightWhenTheLeftWheelIsFaster) {
  Er1 dialogue({});
  begin(dialogue);
  dialogue.drive({.vx = 300, .omega = 0.5F}, line_->now());
  line_->run(1s);
  EXPECT_NEAR(robot_.body().left(), 395, 1);
  EXPECT_NEAR(robot_.body().right(), 205, 1);
  EXPECT_GT(robot_.body().pose().rho, 0.2);
}

TEST_F(Er1DialogueTest, CountsWhatTheWheelsDo) {
  Er1 dialogue({.ticks_per_mm = Er1Emulator::kTicksOfMillimetre});
  begin(dialogue);
  dialogue.drive({.vx = 300, .omega = 0.5F}, line_->now());
  double x = 0;
  double heading = 0;
  for (int i = 0; i < 30; ++i) {
    ASSERT_TRUE(wait_for_data(dialogue));
    x += static_cast<double>(data_.deltaX.raw());
    heading += static_cast<double>(data_.deltaRho.raw());
  }
  EXPECT_NEAR(x, (robot_.body().left_distance() + robot_.body().right_distance()) / 2, 10);
  EXPECT_NEAR(heading, robot_.body().pose().rho, 0.03);
}

TEST_F(Er1DialogueTest, WithoutCountersOdometryFollowsTheCommands) {
  Er1 dialogue({.odometry_factor = 1.17, .odometry_offset = 40});
  begin(dialogue);
  dialogue.drive({.vx = 200}, line_->now());
  line_->run(500ms);
  ASSERT_TRUE(wait_for_data(dialogue));
  ASSERT_TRUE(wait_for_data(dialogue));
  EXPECT_NEAR(data_.vx.raw(), 194, 0.1);
  EXPECT_NEAR(data_.deltaX.raw(), 19.4, 0.8);
}

TEST_F(Er1DialogueTest, ASpeedIsSentAtOnce) {
  Er1 dialogue({});
  begin(dialogue);
  line_->run(30ms);
  dialogue.drive({.vx = 200}, line_->now());
  line_->run(30ms);
  EXPECT_FALSE(robot_.body().must_stop());
  dialogue.drive({}, line_->now());
  line_->run(30ms);
  EXPECT_TRUE(robot_.body().must_stop());
}

TEST_F(Er1DialogueTest, StopsWhenItIsClosedOrItsGuardActs) {
  Er1 dialogue({});
  begin(dialogue);
  dialogue.drive({.vx = 200}, line_->now());
  line_->run(1s);
  EXPECT_TRUE(robot_.is_powered());
  line_->stop_host();
  line_->run(10ms);
  EXPECT_TRUE(robot_.body().must_stop());
  EXPECT_FALSE(robot_.is_powered());
}

TEST_F(Er1DialogueTest, ALostAnswerIsAskedForAgain) {
  Er1 dialogue({.ticks_per_mm = 20});
  begin(dialogue);
  int n = 0;
  line_->set_lose(
      [&](bool from_host, std::span<const std::byte>) { return !from_host && ++n % 5 == 0; });
  dialogue.drive({.vx = 200}, line_->now());
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(wait_for_data(dialogue));
  EXPECT_NEAR(robot_.body().left(), 200, 1);
}

TEST_F(Er1DialogueTest, AMissingAnswerIsReported) {
  Er1 dialogue({});
  begin(dialogue);
  line_->set_lose([](bool, std::span<const std::byte>) { return true; });
  line_->run(1s, [&] { return dialogue.failure().has_value(); });
  ASSERT_TRUE(dialogue.failure());
  EXPECT_THAT(dialogue.failure()->detail(), testing::HasSubstr("does not answer"));
}

TEST_F(Er1DialogueTest, NoiseBreaksNothing) {
  std::mt19937 random(1);
  Er1 dialogue({.ticks_per_mm = 20});
  begin(dialogue);
  for (int i = 0; i < 1000; ++i) {
    std::vector<std::byte> noise(random() % 9);
    for (std::byte& byte : noise) byte = static_cast<std::byte>(random() % 4);
    line_->disturb(noise);
    line_->run(10ms);
    if (dialogue.failure()) line_->start();
  }
}

}  // namespace er1_test
}  // namespace rack::device
