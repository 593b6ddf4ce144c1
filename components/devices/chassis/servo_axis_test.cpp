#include "components/devices/chassis/servo_axis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/chassis/motor_bus.h"
#include "rack/devices/virtual_line.h"

namespace rack::device {
namespace servo_axis_test {

using namespace std::chrono_literals;

constexpr double kIncrements = 4096;

class ServoAxisTest : public testing::Test {
 protected:
  void build(ServoAxisSettings settings) {
    settings.drive.node = 7;
    settings.drive.increments_of_turn = settings.drive.velocity_of_turn = kIncrements;
    bus_.add(std::make_unique<Cia402Emulator>(7, kIncrements, kIncrements));
    axis_.emplace(settings);
    line_.emplace(*axis_, bus_, emulator::LineSettings{.is_bus = true, .delay = 100us});
    line_->start();
    line_->run(5s, [&] { return axis_->is_ready(); });
    ASSERT_TRUE(axis_->is_ready());
  }
  double position() {
    ServoDriveData data;
    Time recorded;
    line_->run(200ms, [&] { return axis_->take(data, recorded); });
    return static_cast<double>(data.position);
  }

  MotorBus bus_;
  std::optional<ServoAxis> axis_;
  std::optional<emulator::VirtualLine> line_;
};

TEST_F(ServoAxisTest, MovesToItsTarget) {
  build({.gear = 10, .min = -2, .max = 2, .velocity_max = 1});
  axis_->move_to(1.5, 0.5, 0);
  line_->run(1500ms);
  EXPECT_FALSE(axis_->is_reached());
  EXPECT_NEAR(position(), 0.75, 0.15);
  line_->run(3s);
  EXPECT_TRUE(axis_->is_reached());
  EXPECT_NEAR(position(), 1.5, 1e-3);
  axis_->move_to(-9, 0, 0);  // outside of the permitted range
  line_->run(5s);
  EXPECT_NEAR(position(), -2, 1e-3);
}

TEST_F(ServoAxisTest, AnAxisMountedInReverse) {
  build({.gear = -10, .min = -2, .max = 2, .velocity_max = 1});
  axis_->move_to(1, 0, 0);
  line_->run(3s);
  EXPECT_NEAR(position(), 1, 1e-3);
  EXPECT_NEAR(bus_.motor(0).shaft().position(), -10, 0.01);
}

TEST_F(ServoAxisTest, MovesUntilItIsStopped) {
  build({.gear = 10, .min = -20, .max = 20, .velocity_max = 1});
  for (int i = 0; i < 20; ++i) {
    axis_->move(0.5, line_->now());
    line_->run(100ms);
  }
  EXPECT_NEAR(position(), 1, 0.2);
  axis_->move(0, line_->now());
  line_->run(200ms);
  const double there = position();
  line_->run(2s);
  EXPECT_NEAR(position(), there, 0.05);
}

TEST_F(ServoAxisTest, StandsWhenNobodyMovesItAnyMore) {
  build({.gear = 10, .min = -20, .max = 20, .velocity_max = 1});
  for (int i = 0; i < 10; ++i) {
    axis_->move(1, line_->now());
    line_->run(50ms);
  }
  EXPECT_NEAR(position(), 0.5, 0.2);
  EXPECT_FALSE(axis_->take_overdue());
  line_->run(200ms);  // more than three periods
  EXPECT_TRUE(axis_->take_overdue());
  const double there = position();
  EXPECT_LT(there, 0.8);
  line_->run(2s);
  EXPECT_NEAR(position(), there, 0.05);
  // A target position is reached even without repetition of the command.
  axis_->move(1, line_->now());
  axis_->move_to(-1, 0, 0);
  line_->run(5s);
  EXPECT_NEAR(position(), -1, 1e-3);
  EXPECT_FALSE(axis_->take_overdue());
}

TEST_F(ServoAxisTest, ATimeThatIsSetHoldsForOneCommand) {
  build({.gear = 10, .min = -20, .max = 20, .velocity_max = 1, .move_deadline = 2s});
  axis_->move(0.5, line_->now());
  line_->run(4s);
  EXPECT_NEAR(position(), 1, 0.1);
}

TEST_F(ServoAxisTest, EachOfManyPositionsIsTaken) {
  build({.gear = 10, .min = -20, .max = 20, .velocity_max = 100});
  for (int i = 1; i <= 50; ++i) {
    axis_->move_to(0.1 * i, 0, 0);
    line_->run(31ms);
  }
  line_->run(2s);
  EXPECT_NEAR(position(), 5, 1e-3);
}

TEST_F(ServoAxisTest, HomeIsHere) {
  build({.gear = 10, .min = -20, .max = 20, .velocity_max = 1});
  axis_->move_to(1, 0, 0);
  line_->run(3s);
  axis_->home();
  line_->run(1s);
  EXPECT_NEAR(position(), 0, 1e-3);
  axis_->move_to(0.5, 0, 0);
  line_->run(2s);
  EXPECT_NEAR(position(), 0.5, 1e-3);
}

TEST_F(ServoAxisTest, ItsStopCommandsStopItFromAnySender) {
  build({.gear = 10, .min = -20, .max = 20, .velocity_max = 1});
  axis_->move(1, line_->now());
  line_->run(100ms);
  ASSERT_TRUE(bus_.motor(0).is_enabled());
  KeptTelegrams nobody;
  for (const Telegram& telegram : axis_->stop_commands())
    bus_.on_arrival(
        {.bytes = telegram.bytes, .first = line_->now(), .last = line_->now(), .id = telegram.id},
        nobody);
  EXPECT_FALSE(bus_.motor(0).is_enabled());
  EXPECT_EQ(bus_.motor(0).shaft().wanted(), 0);
}

TEST_F(ServoAxisTest, StopsWithItsHost) {
  build({.gear = 10, .min = -20, .max = 20, .velocity_max = 1});
  axis_->move(1, line_->now());
  line_->run(100ms);
  EXPECT_TRUE(bus_.motor(0).is_enabled());
  line_->set_lose([](bool, std::span<const std::byte>) { return true; });
  line_->run(400ms);
  EXPECT_EQ(bus_.motor(0).shaft().wanted(), 0);
  EXPECT_FALSE(bus_.motor(0).is_enabled());
}

TEST(ServoAxisData, IsKnownBetweenTwoDataSets) {
  const ServoDriveData before{.recordingTime = 0xFFFFFFF6, .position = -0.5F};
  const ServoDriveData after{.recordingTime = 40, .position = 0.5F};
  const ServoDriveData now = interpolated(before, after, 15);
  EXPECT_EQ(now.recordingTime, TimeStamp(15));
  EXPECT_NEAR(now.position, 0, 1e-6);
  EXPECT_EQ(interpolated(after, after, 40).position, 0.5F);
}

}  // namespace servo_axis_test
}  // namespace rack::device
