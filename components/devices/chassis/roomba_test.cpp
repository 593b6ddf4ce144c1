#include "components/devices/chassis/roomba.h"

#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/chassis/roomba_robot.h"
#include "components/devices/core/virtual_line.h"

namespace rack::device {
namespace roomba_test {

using namespace std::chrono_literals;

// Loses this share of the messages.
emulator::VirtualLine::Lose lost(double share) {
  return [share, random = std::mt19937(1)](bool, std::span<const std::byte>) mutable {
    return std::bernoulli_distribution(share)(random);
  };
}

class RoombaTest : public testing::TestWithParam<RoombaModel> {
 protected:
  RoombaSettings settings() const {
    return {.model = GetParam(), .track = GetParam() == RoombaModel::kRoomba ? 258.0 : 235.0};
  }
  bool wait_for_data(Roomba& dialogue, Duration longest = 3s) {
    bool has = false;
    line_->run(longest, [&] {
      has = has || dialogue.take(data_, recorded_);
      return has || dialogue.failure();
    });
    return has;
  }
  void begin(Roomba& dialogue) {
    line_.emplace(dialogue, robot_, emulator::LineSettings{.delay = 1ms});
    line_->start();
    ASSERT_TRUE(wait_for_data(dialogue));
  }

  RoombaEmulator robot_{GetParam()};
  std::optional<emulator::VirtualLine> line_;
  ChassisData data_;
  Time recorded_{};
};

TEST_P(RoombaTest, DrivesAndCounts) {
  Roomba dialogue(settings());
  begin(dialogue);
  EXPECT_TRUE(robot_.is_in_control());
  EXPECT_FLOAT_EQ(data_.battery.raw(), 16);
  for (const ChassisSpeed& speed : {ChassisSpeed{200, 0, 0.4F},
                                    {-200, 0, 0.3F},
                                    {150, 0, -0.5F},
                                    {0, 0, 0.5F},
                                    {0, 0, -0.5F},
                                    {300, 0, 0}}) {
    dialogue.drive(speed, line_->now());
    line_->run(500ms);
    ASSERT_TRUE(wait_for_data(dialogue));
    double x = 0;
    double heading = 0;
    const double distance_before =
        (robot_.body().left_distance() + robot_.body().right_distance()) / 2;
    const double turned = robot_.body().pose().rho;
    for (int i = 0; i < 20; ++i) {
      ASSERT_TRUE(wait_for_data(dialogue));
      x += static_cast<double>(data_.deltaX.raw());
      heading += static_cast<double>(data_.deltaRho.raw());
    }
    EXPECT_NEAR(
        x, (robot_.body().left_distance() + robot_.body().right_distance()) / 2 - distance_before,
        35);
    EXPECT_NEAR(heading, robot_.body().pose().rho - turned, 0.06);
    EXPECT_NEAR(robot_.body().left() - robot_.body().right(),
                static_cast<double>(speed.omega) * settings().track, 2);
    EXPECT_NEAR(robot_.body().left() + robot_.body().right(), 2 * static_cast<double>(speed.vx), 2);
  }
}

TEST_P(RoombaTest, ASpeedIsSentAtOnce) {
  Roomba dialogue(settings());
  begin(dialogue);
  dialogue.drive({.vx = 200}, line_->now());
  line_->run(20ms);
  EXPECT_FALSE(robot_.body().must_stop());
  dialogue.drive({}, line_->now());
  line_->run(20ms);
  EXPECT_TRUE(robot_.body().must_stop());
}

TEST_P(RoombaTest, StandsWhenItIsLeft) {
  Roomba dialogue(settings());
  begin(dialogue);
  dialogue.drive({.vx = 200}, line_->now());
  line_->run(1s);
  line_->stop_host();
  line_->run(10ms);
  EXPECT_TRUE(robot_.body().must_stop());
}

TEST_P(RoombaTest, TheStopCommandsOfTheGuardFollowAnyTruncatedCommand) {
  for (std::size_t cut = 0; cut < 5; ++cut) {
    Roomba dialogue(settings());
    robot_ = RoombaEmulator(GetParam());
    begin(dialogue);
    dialogue.drive({.vx = 200}, line_->now());
    line_->run(1s);
    struct Nobody final : Output {
      void send(std::span<const std::byte>, std::uint32_t) override {}
    } nobody;
    const std::array<std::byte, 5> last{std::byte{0x89}, {}, std::byte{200}, std::byte{0x80}, {}};
    robot_.on_arrival({.bytes = std::span(last).first(cut), .last = line_->now()}, nobody);
    robot_.on_arrival({.bytes = kRoombaStop, .last = line_->now()}, nobody);
    EXPECT_TRUE(robot_.body().must_stop()) << cut;
  }
}

TEST_P(RoombaTest, BumpsArePoints) {
  Roomba dialogue(settings());
  robot_.bumps = 3;
  begin(dialogue);
  Scan2dData scan;
  dialogue.look(scan);
  ASSERT_EQ(scan.points.size(), 2U);
  EXPECT_EQ(scan.points[0].x, 195);
  EXPECT_EQ(scan.points[0].y, -95);
}

TEST_P(RoombaTest, ABlockedWheelEndsIt) {
  Roomba dialogue(settings());
  begin(dialogue);
  robot_.overcurrents = 8;
  line_->run(3s, [&] { return dialogue.failure().has_value(); });
  ASSERT_TRUE(dialogue.failure());
  EXPECT_THAT(dialogue.failure()->detail(), testing::HasSubstr("overcurrent of a wheel"));
}

TEST_P(RoombaTest, LostBytesCostData) {
  Roomba dialogue(settings());
  begin(dialogue);
  line_->set_lose(lost(0.2));
  int data = 0;
  for (int i = 0; i < 50; ++i) data += wait_for_data(dialogue, 100ms) ? 1 : 0;
  EXPECT_GT(data, 15);
}

TEST_P(RoombaTest, NoiseBreaksNothing) {
  std::mt19937 random(1);
  Roomba dialogue(settings());
  begin(dialogue);
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::byte> noise(random() % 60);
    for (std::byte& byte : noise) byte = static_cast<std::byte>(random() % 32);
    line_->disturb(noise);
    line_->run(10ms);
  }
}

INSTANTIATE_TEST_SUITE_P(Models, RoombaTest,
                         testing::Values(RoombaModel::kRoomba, RoombaModel::kCreate2),
                         [](const auto& model) {
                           return model.param == RoombaModel::kRoomba ? "Roomba" : "Create2";
                         });

// What the original's ChassisRoomba sends at ON, and its commands: it takes control by CONTROL, not
// by FULL, and plays a note, whose bytes are no commands.
TEST(RoombaRobotTest, ObeysTheDriverOfTheOriginal) {
  struct CountingOutput final : Output {
    void send(std::span<const std::byte> bytes, std::uint32_t) override { sent += bytes.size(); }
    std::size_t sent = 0;
  } output;
  RoombaEmulator robot(RoombaModel::kRoomba);
  robot.start(Time(1s), output);
  Time now(1s);
  const auto send = [&](std::initializer_list<int> values) {
    std::vector<std::byte> bytes;
    for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
    now += 20ms;
    robot.on_arrival({.bytes = bytes, .first = now, .last = now}, output);
  };
  send({0x80});
  send({0x89, 0, 100, 0x80, 0});
  EXPECT_FALSE(robot.is_in_control()) << "passive after START";
  EXPECT_TRUE(robot.body().must_stop());
  send({0x81, 7});
  send({0x82});
  EXPECT_TRUE(robot.is_in_control());
  send({0x8C, 0x0F, 1, 0x80, 12});  // a note of the number of START does not end the control
  send({0x8D, 0x0F});
  EXPECT_TRUE(robot.is_in_control());
  send({0x8A, 5});
  EXPECT_EQ(robot.motors(), 5);
  send({0x89, 0, 200, 0x80, 0});
  EXPECT_FALSE(robot.body().must_stop());
  send({0x8E, 0});
  EXPECT_EQ(output.sent, 26U);
  for (int i = 0; i < 50; ++i) send({0x89, 0, 100, 0xFF, 0xFF});  // on the spot, clockwise
  EXPECT_GT(robot.body().left(), 50);
  EXPECT_LT(robot.body().right(), -50);
  send({0x89, 0, 0, 0x80, 0});
  EXPECT_TRUE(robot.body().must_stop());
  send({0x8C, 0, 17});  // a longer song than there is: dropped, and the next command is taken
  send({0x89, 0, 200, 0x80, 0});
  EXPECT_FALSE(robot.body().must_stop());
}

TEST(Create2FramesTest, EverySplitAndEveryFlippedBit) {
  struct RecordingOutput final : Output {
    void send(std::span<const std::byte> bytes, std::uint32_t) override {
      received.insert(received.end(), bytes.begin(), bytes.end());
    }
    std::vector<std::byte> received;
  } output;
  RoombaEmulator robot(RoombaModel::kCreate2);
  const std::array start{std::byte{0x80}, std::byte{0x94}, std::byte{1}, std::byte{7}};
  robot.on_arrival({.bytes = start, .last = Time(1s)}, output);
  for (int i = 0; i < 3; ++i) robot.on_timeout(robot.next_timeout(), output);
  const auto frames_in = [](std::initializer_list<std::span<const std::byte>> pieces) {
    Create2Frames frames;
    RoombaSensors sensors;
    Time began;
    int count = 0;
    for (const auto piece : pieces) {
      frames.add({.bytes = piece});
      while (frames.next(sensors, began)) ++count;
    }
    return count;
  };
  const std::span all(output.received);
  for (std::size_t cut = 0; cut <= all.size(); ++cut)
    EXPECT_EQ(frames_in({all.first(cut), all.subspan(cut)}), 3) << cut;
  for (std::size_t bit = 0; bit < all.size() * 8; ++bit) {
    auto broken = output.received;
    broken[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    EXPECT_EQ(frames_in({broken, all}), 5) << bit;
  }
}

// The worked example of iRobot's specification: backwards at 200 mm/s on a radius of 500 mm.
TEST(RoombaDriveTest, ADriveCommandIsThatOfTheSpecification) {
  struct RecordingOutput final : Output {
    void send(std::span<const std::byte> bytes, std::uint32_t) override {
      if (bytes.size() == 5) last.assign(bytes.begin(), bytes.end());
    }
    std::vector<std::byte> last;
  } output;
  Roomba dialogue({});
  Time now{100s};
  dialogue.start(now, output);
  for (; !dialogue.is_ready(); now += 10ms)
    if (dialogue.next_timeout() <= now) dialogue.on_timeout(now, output);
  dialogue.drive({.vx = -200, .omega = 0.4F}, now);
  dialogue.on_timeout(now + 100ms, output);
  EXPECT_EQ(output.last, (std::vector{std::byte{137}, std::byte{255}, std::byte{56}, std::byte{1},
                                      std::byte{244}}));
}

TEST(RoombaSensorsTest, WhatCannotBeIsNone) {
  std::vector<std::byte> bytes(26);
  RoombaSensors sensors;
  EXPECT_TRUE(decode_roomba_sensors(bytes, 258, sensors));
  EXPECT_FALSE(decode_roomba_sensors(std::span(bytes).first(25), 258, sensors));
  bytes[3] = std::byte{2};
  EXPECT_FALSE(decode_roomba_sensors(bytes, 258, sensors));
}

}  // namespace roomba_test
}  // namespace rack::device
