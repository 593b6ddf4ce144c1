#include "components/devices/chassis/p2os.h"

#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/chassis/pioneer.h"
#include "components/devices/core/virtual_line.h"

namespace rack::device {
namespace p2os_test {

using namespace std::chrono_literals;

// Loses this share of the packets.
emulator::VirtualLine::Lose lost(double share) {
  return [share, random = std::mt19937(1)](bool, std::span<const std::byte>) mutable {
    return std::bernoulli_distribution(share)(random);
  };
}

std::vector<int> numbers(std::span<const std::byte> bytes) {
  std::vector<int> numbers;
  for (const std::byte byte : bytes) numbers.push_back(std::to_integer<int>(byte));
  return numbers;
}

TEST(P2osTest, PacketsAreThoseOfTheManual) {
  using testing::ElementsAre;
  EXPECT_THAT(numbers(p2os_sync(0).view()), ElementsAre(0xFA, 0xFB, 3, 0, 0, 0));
  EXPECT_THAT(numbers(p2os_sync(2).view()), ElementsAre(0xFA, 0xFB, 3, 2, 0, 2));
  EXPECT_THAT(numbers(p2os_command(P2osCommand::kOpen).view()),
              ElementsAre(0xFA, 0xFB, 3, 1, 0, 1));
  EXPECT_THAT(numbers(p2os_command(P2osCommand::kEnable, 1).view()),
              ElementsAre(0xFA, 0xFB, 6, 4, 0x3B, 1, 0, 5, 0x3B));
  EXPECT_THAT(numbers(p2os_command(P2osCommand::kVelocity, -300).view()),
              ElementsAre(0xFA, 0xFB, 6, 11, 0x1B, 0x2C, 0x01, 0x37, 0x1C));
}

class P2osDialogueTest : public testing::Test {
 protected:
  // Waits for data; false if the dialogue has given up.
  bool open(P2os& dialogue) {
    line_.emplace(dialogue, robot_, emulator::LineSettings{.delay = 1ms});
    line_->start();
    return wait_for_data(dialogue);
  }
  bool wait_for_data(P2os& dialogue, Duration longest = 20s) {
    bool has = false;
    line_->run(longest, [&] {
      has = has || dialogue.take(data_, recorded_);
      return has || dialogue.failure();
    });
    return has;
  }

  PioneerEmulator robot_;
  std::optional<emulator::VirtualLine> line_;
  ChassisData data_;
  Time recorded_{};
};

TEST_F(P2osDialogueTest, OpensTheRobotAndDrivesIt) {
  P2os dialogue({});
  ASSERT_TRUE(open(dialogue));
  EXPECT_EQ(dialogue.robot(), "Emulated Pioneer p3dx");
  EXPECT_TRUE(robot_.is_enabled());
  EXPECT_FLOAT_EQ(data_.battery.raw(), 12.5F);
  dialogue.drive({.vx = 300, .omega = 0.2F}, line_->now());
  double x = 0;
  double heading = 0;
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(wait_for_data(dialogue));
    x += static_cast<double>(data_.deltaX.raw());
    heading += static_cast<double>(data_.deltaRho.raw());
  }
  EXPECT_NEAR(data_.vx.raw(), 300, 2);
  EXPECT_NEAR(data_.omega.raw(), 0.2, 0.02);
  EXPECT_NEAR(x, (robot_.body().left_distance() + robot_.body().right_distance()) / 2, 40);
  EXPECT_NEAR(heading, robot_.body().pose().rho, 0.03);
  EXPECT_GT(x, 2500);
}

TEST_F(P2osDialogueTest, ASpeedIsSentAtOnceAndTenMillisecondsApart) {
  P2os dialogue({});
  ASSERT_TRUE(open(dialogue));
  line_->run(333ms);
  dialogue.drive({.vx = 300, .omega = 0.2F}, line_->now());
  line_->run(25ms);
  EXPECT_FALSE(robot_.body().must_stop());
  const Time now = line_->now();
  dialogue.drive({}, now);
  line_->run(25ms);
  EXPECT_TRUE(robot_.body().must_stop());
}

TEST_F(P2osDialogueTest, LeavesARobotThatStands) {
  P2os dialogue({});
  ASSERT_TRUE(open(dialogue));
  dialogue.drive({.vx = 300}, line_->now());
  line_->run(2s);
  EXPECT_FALSE(robot_.body().stands());
  line_->stop_host();
  line_->run(10ms);
  EXPECT_TRUE(robot_.body().must_stop());
  EXPECT_FALSE(robot_.is_open());
}

TEST_F(P2osDialogueTest, TheRobotStopsByItselfWhenTheHostIsGone) {
  P2os dialogue({});
  ASSERT_TRUE(open(dialogue));
  dialogue.drive({.vx = 300}, line_->now());
  line_->run(10s);
  EXPECT_FALSE(robot_.body().must_stop());  // the watchdog is fed while the host runs
  line_->set_lose([](bool, std::span<const std::byte>) { return true; });
  line_->run(2200ms);
  EXPECT_TRUE(robot_.body().must_stop());
}

TEST_F(P2osDialogueTest, ComesBackToARobotThatIsStillOpen) {
  P2os dialogue({});
  ASSERT_TRUE(open(dialogue));
  line_->start();
  EXPECT_TRUE(wait_for_data(dialogue));
}

TEST_F(P2osDialogueTest, LostPacketsDelayIt) {
  for (const double loss : {0.02, 0.1}) {
    P2os dialogue({});
    robot_ = PioneerEmulator();
    line_.emplace(dialogue, robot_, emulator::LineSettings{.delay = 1ms});
    line_->set_lose(lost(loss));
    line_->start();
    for (int i = 0; i < 30 && !wait_for_data(dialogue, 10s); ++i) line_->start();
    dialogue.drive({.vx = 200}, line_->now());
    line_->run(3s);
    EXPECT_TRUE(dialogue.is_ready()) << loss;
  }
}

TEST_F(P2osDialogueTest, AMissingAnswerIsReported) {
  P2os dialogue({});
  line_.emplace(dialogue, robot_, emulator::LineSettings{.delay = 1ms});
  line_->set_lose([](bool, std::span<const std::byte>) { return true; });
  line_->start();
  line_->run(20s, [&] { return dialogue.failure().has_value(); });
  ASSERT_TRUE(dialogue.failure());
  EXPECT_THAT(dialogue.failure()->detail(), testing::HasSubstr("does not answer to SYNC"));
}

TEST_F(P2osDialogueTest, SonarsAreRaysAroundTheRobot) {
  P2os dialogue({.sonar = true});
  ASSERT_TRUE(open(dialogue));
  LadarData rays;
  ASSERT_TRUE(dialogue.take_sonars(rays, recorded_));
  ASSERT_EQ(rays.points.size(), kP2osSonars);
  EXPECT_EQ(rays.points[3].distance, 268);
  EXPECT_EQ(rays.points[4].distance, 536);
  EXPECT_EQ(rays.points[5].type, ladar_point::kInvalid);
  EXPECT_NEAR(rays.points[4].angle.raw(), 0.1745, 1e-3);
}

// What the original's ChassisPioneer sends for turns to the right: the type of numbers that are not
// negative (3B), and a negative number of 16 bits. Bytes by its checksum.
TEST(PioneerRobotTest, ObeysTheDriverOfTheOriginal) {
  struct Nobody final : Output {
    void send(std::span<const std::byte>, std::uint32_t) override {}
  } nobody;
  PioneerEmulator robot;
  Time now{100s};
  robot.start(now, nobody);
  const auto send = [&](std::initializer_list<int> values) {
    std::vector<std::byte> bytes;
    for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
    now += 10ms;
    robot.on_arrival({.bytes = bytes, .first = now, .last = now}, nobody);
    while (robot.next_timeout() <= now) robot.on_timeout(robot.next_timeout(), nobody);
  };
  send({0xFA, 0xFB, 3, 0, 0, 0});
  send({0xFA, 0xFB, 3, 1, 0, 1});
  send({0xFA, 0xFB, 3, 2, 0, 2});
  send({0xFA, 0xFB, 3, 1, 0, 1});
  send({0xFA, 0xFB, 6, 4, 0x3B, 1, 0, 5, 0x3B});
  ASSERT_TRUE(robot.is_enabled());
  send({0xFA, 0xFB, 6, 21, 0x3B, 0xEC, 0xFF, 0x02, 0x3A});  // RVEL -20: to the right
  for (int i = 0; i < 100; ++i) send({0xFA, 0xFB, 3, 0, 0, 0});
  constexpr double kTwentyDegrees = 20 * std::numbers::pi / 180;
  EXPECT_NEAR((robot.body().left() - robot.body().right()) / robot.body().track(), kTwentyDegrees,
              1e-3);
  EXPECT_GT(robot.body().pose().rho, 0);
  // The same number in the way of the manual.
  const auto packet = p2os_command(P2osCommand::kTurn, -20);
  now += 10ms;
  robot.on_arrival({.bytes = packet.view(), .first = now, .last = now}, nobody);
  for (int i = 0; i < 100; ++i) send({0xFA, 0xFB, 3, 0, 0, 0});
  EXPECT_NEAR((robot.body().left() - robot.body().right()) / robot.body().track(), kTwentyDegrees,
              1e-3);
  // Backward, as both send it.
  send({0xFA, 0xFB, 6, 11, 0x1B, 100, 0, 0x6F, 0x1B});
  for (int i = 0; i < 100; ++i) send({0xFA, 0xFB, 3, 0, 0, 0});
  EXPECT_NEAR((robot.body().left() + robot.body().right()) / 2, -100, 1);
}

std::vector<std::byte> recorded_stream() {
  struct RecordingOutput final : Output {
    void send(std::span<const std::byte> bytes, std::uint32_t) override {
      received.insert(received.end(), bytes.begin(), bytes.end());
    }
    std::vector<std::byte> received;
  } output;
  PioneerEmulator robot;
  Time now{100s};
  for (const auto& packet :
       {p2os_sync(0), p2os_sync(1), p2os_sync(2), p2os_command(P2osCommand::kOpen),
        p2os_command(P2osCommand::kEncoder, 2)})
    robot.on_arrival({.bytes = packet.view(), .first = now, .last = now}, output);
  output.received.clear();
  for (int i = 0; i < 3; ++i) robot.on_timeout(robot.next_timeout(), output);
  return output.received;
}

int data_sets(std::initializer_list<std::span<const std::byte>> pieces) {
  struct Nobody final : Output {
    void send(std::span<const std::byte>, std::uint32_t) override {}
  } nobody;
  P2os dialogue({.only_listen = true});
  dialogue.start({}, nobody);
  int count = 0;
  for (const auto piece : pieces) {
    for (const std::byte& byte : piece) {
      dialogue.on_arrival({.bytes = std::span(&byte, 1)}, nobody);
      ChassisData data;
      Time recorded;
      count += dialogue.take(data, recorded) ? 1 : 0;
    }
  }
  return count;
}

TEST(P2osStreamTest, EverySplitAndEveryBeginning) {
  const auto stream = recorded_stream();
  const std::span all(stream);
  EXPECT_EQ(data_sets({all}), 3);
  for (std::size_t cut = 0; cut < stream.size(); ++cut)
    EXPECT_GE(data_sets({all.subspan(cut), all}), 3) << cut;
}

TEST(P2osStreamTest, AFlippedBitCostsOnePacket) {
  const auto stream = recorded_stream();
  for (std::size_t bit = 0; bit < stream.size() * 8; ++bit) {
    auto broken = stream;
    broken[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    // A wrong length causes the loss of the following packets, until it is detected.
    EXPECT_GE(data_sets({broken, stream, stream}), 8 - 3) << bit;
  }
}

TEST(P2osStreamTest, NoiseBreaksNothing) {
  std::mt19937 random(1);
  std::vector<std::byte> noise(200000);
  for (std::byte& byte : noise) byte = static_cast<std::byte>(0xFA + random() % 8);
  data_sets({noise});
}

}  // namespace p2os_test
}  // namespace rack::device
