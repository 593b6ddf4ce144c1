#include "components/devices/chassis/motor_chassis.h"

#include <algorithm>
#include <bit>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/chassis/motor_bus.h"
#include "rack/devices/virtual_line.h"

namespace rack::device {
namespace motor_chassis_test {

using namespace std::chrono_literals;

// Loses this share of the frames.
emulator::VirtualLine::Lose lost(double share) {
  return [share, random = std::mt19937(1)](bool, std::span<const std::byte>) mutable {
    return std::bernoulli_distribution(share)(random);
  };
}

constexpr double kGear = 0.05;  // rad/mm: a wheel of 100 mm radius, gear 5
constexpr int kPolePairs = 7;
constexpr double kIncrements = 8192;

enum class Kind : std::uint8_t { kOdrive, kVesc, kCia402 };

std::vector<int> numbers(std::span<const std::byte> bytes) {
  std::vector<int> numbers;
  for (const std::byte byte : bytes) numbers.push_back(std::to_integer<int>(byte));
  return numbers;
}

struct RecordingOutput final : Output {
  void send(std::span<const std::byte> bytes, std::uint32_t id) override {
    frames.emplace_back(id, numbers(bytes));
  }
  void send_before(Time deadline, std::span<const std::byte> bytes, std::uint32_t id) override {
    send(bytes, id);
    deadlines.push_back(deadline);
  }
  std::vector<std::pair<std::uint32_t, std::vector<int>>> frames;
  std::vector<Time> deadlines;
};

class MotorChassisTest : public testing::TestWithParam<Kind> {
 protected:
  std::unique_ptr<Motor> motor(std::uint8_t node, MotorTask task) const {
    if (GetParam() == Kind::kOdrive) return std::make_unique<Odrive>(node, task);
    if (GetParam() == Kind::kVesc)
      return std::make_unique<Vesc>(
          VescSettings{.node = node, .task = task, .pole_pairs = kPolePairs});
    return std::make_unique<Cia402>(Cia402Settings{.node = node,
                                                   .task = task,
                                                   .increments_of_turn = kIncrements,
                                                   .velocity_of_turn = kIncrements});
  }
  std::unique_ptr<EmulatedMotor> emulated(std::uint8_t node) const {
    if (GetParam() == Kind::kOdrive) return std::make_unique<OdriveEmulator>(node);
    if (GetParam() == Kind::kVesc) return std::make_unique<VescEmulator>(node, kPolePairs);
    return std::make_unique<Cia402Emulator>(node, kIncrements, kIncrements);
  }
  void build(const Wheels& wheels) {
    std::vector<MotorLink> links;
    for (std::size_t i = 0; i < wheels.motors(); ++i) {
      const auto node = static_cast<std::uint8_t>(10 + i);
      const bool steers = wheels.is_steering(i);
      bus_.add(emulated(node));
      links.push_back({motor(node, steers ? MotorTask::kPositions : MotorTask::kTurns),
                       "motor of node " + std::to_string(node), steers ? 1.0 : kGear});
    }
    chassis_.emplace(
        MotorChassisSettings{.period = 50ms, .is_canopen = GetParam() == Kind::kCia402}, wheels,
        std::move(links));
    line_.emplace(*chassis_, bus_, emulator::LineSettings{.is_bus = true, .delay = 100us});
    line_->start();
  }
  bool wait_for_data(Duration longest = 10s) {
    bool has = false;
    line_->run(longest, [&] {
      has = has || chassis_->take(data_, recorded_);
      return has || chassis_->failure();
    });
    if (chassis_->failure()) ADD_FAILURE() << chassis_->failure()->detail();
    return has;
  }
  void expect_it_drives(const ChassisSpeed& speed) {
    chassis_->drive(speed, line_->now());
    line_->run(1s);
    ASSERT_TRUE(wait_for_data());
    ChassisSpeed displacement;
    const Time begin = recorded_;
    for (int i = 0; i < 20; ++i) {
      ASSERT_TRUE(wait_for_data());
      displacement.vx += data_.deltaX.raw();
      displacement.vy += data_.deltaY.raw();
      displacement.omega += data_.deltaRho.raw();
    }
    const float seconds = std::chrono::duration<float>(recorded_ - begin).count();
    EXPECT_NEAR(data_.vx.raw(), speed.vx, 3);
    EXPECT_NEAR(data_.vy.raw(), speed.vy, 3);
    EXPECT_NEAR(data_.omega.raw(), speed.omega, 0.01);
    EXPECT_NEAR(displacement.vx, speed.vx * seconds, 30);
    EXPECT_NEAR(displacement.omega, speed.omega * seconds, 0.03);
  }

  MotorBus bus_;
  std::optional<MotorChassis> chassis_;
  std::optional<emulator::VirtualLine> line_;
  ChassisData data_;
  Time recorded_{};
};

TEST_P(MotorChassisTest, ADifferentialDrive) {
  build(Wheels::differential(400));
  ASSERT_TRUE(wait_for_data());
  expect_it_drives({.vx = 500, .omega = 0.5F});
  expect_it_drives({.vx = -300});
  expect_it_drives({.omega = -0.6F});
  if (GetParam() != Kind::kCia402) {
    EXPECT_GT(data_.battery.raw(), 20);
  }
}

TEST_P(MotorChassisTest, ASteeredVehicle) {
  build(Wheels::ackermann(1000, 600, false, 0.6));
  ASSERT_TRUE(wait_for_data());
  expect_it_drives({.vx = 800, .omega = 0.2F});
  expect_it_drives({.vx = -400, .omega = 0.1F});
}

TEST_P(MotorChassisTest, BothAxlesSteered) {
  build(Wheels::double_ackermann(1200, 1000, 0.4));
  ASSERT_TRUE(wait_for_data());
  expect_it_drives({.vx = 1000, .omega = 0.3F});
  expect_it_drives({.vx = 1000, .vy = 200});
}

TEST_P(MotorChassisTest, ASpeedIsSentAtOnce) {
  build(Wheels::differential(400));
  ASSERT_TRUE(wait_for_data());
  chassis_->drive({.vx = 500}, line_->now());
  line_->run(1s);
  EXPECT_NEAR(bus_.motor(0).shaft().velocity(), 500 * kGear, 0.1);
  chassis_->drive({}, line_->now());
  line_->run(6ms);
  EXPECT_EQ(bus_.motor(0).shaft().wanted(), 0);
}

TEST_P(MotorChassisTest, AllStandWhenItIsLeft) {
  build(Wheels::differential(400));
  ASSERT_TRUE(wait_for_data());
  chassis_->drive({.vx = 500}, line_->now());
  line_->run(1s);
  line_->stop_host();
  line_->run(200ms);
  EXPECT_TRUE(bus_.stands());
  EXPECT_EQ(chassis_->next_timeout(), tims::kNever);
}

TEST_P(MotorChassisTest, MotorsStopByThemselvesWhenTheHostIsGone) {
  build(Wheels::differential(400));
  ASSERT_TRUE(wait_for_data());
  chassis_->drive({.vx = 500}, line_->now());
  line_->run(10s);
  EXPECT_FALSE(bus_.stands());
  line_->set_lose([](bool, std::span<const std::byte>) { return true; });
  line_->run(GetParam() == Kind::kVesc ? 1200ms : 400ms);
  EXPECT_TRUE(bus_.stands());
}

TEST_P(MotorChassisTest, ItsStopCommandsStopTheMotorsFromAnySender) {
  build(Wheels::ackermann(1000, 600, false, 0.6));
  const auto commands = chassis_->stop_commands();  // before any communication
  ASSERT_TRUE(wait_for_data());
  chassis_->drive({.vx = 500}, line_->now());
  line_->run(1s);
  RecordingOutput nobody;
  for (const Telegram& telegram : commands)
    bus_.on_arrival(
        {.bytes = telegram.bytes, .first = line_->now(), .last = line_->now(), .id = telegram.id},
        nobody);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(bus_.motor(i).shaft().wanted(), 0) << i;
    if (GetParam() != Kind::kVesc) {
      EXPECT_FALSE(bus_.motor(i).is_enabled()) << i;
    }
  }
}

TEST_P(MotorChassisTest, ASilentMotorStopsTheOther) {
  build(Wheels::differential(400));
  ASSERT_TRUE(wait_for_data());
  chassis_->drive({.vx = 500}, line_->now());
  line_->run(1s);
  bus_.cut_off(1);
  line_->run(2s, [&] { return chassis_->failure().has_value(); });
  ASSERT_TRUE(chassis_->failure());
  EXPECT_THAT(chassis_->failure()->detail(), testing::StartsWith("motor of node 11 "));
  line_->run(200ms);
  EXPECT_TRUE(bus_.stands());
}

TEST_P(MotorChassisTest, AMissingMotorIsNamed) {
  build(Wheels::differential(400));
  line_->set_lose([](bool, std::span<const std::byte>) { return true; });
  line_->run(20s, [&] { return chassis_->failure().has_value(); });
  ASSERT_TRUE(chassis_->failure());
  EXPECT_THAT(chassis_->failure()->detail(), testing::HasSubstr("motor of node 10"));
}

TEST_P(MotorChassisTest, LostFramesDelayIt) {
  build(Wheels::differential(400));
  line_->set_lose(lost(0.05));
  ASSERT_TRUE(wait_for_data());
  chassis_->drive({.vx = 500}, line_->now());
  line_->run(2s);
  EXPECT_NEAR(bus_.motor(0).shaft().velocity(), 500 * kGear, 0.1);
}

TEST_P(MotorChassisTest, FramesOfOthersAndNoiseBreakNothing) {
  build(Wheels::differential(400));
  ASSERT_TRUE(wait_for_data());
  std::mt19937 numbers(1);
  const auto random = [&] { return static_cast<std::uint32_t>(numbers()); };
  RecordingOutput nobody;
  for (int i = 0; i < 5000; ++i) {
    std::array<std::byte, 8> bytes{};
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
    // From any node except these two; also error frames.
    const std::uint32_t node = 20 + random() % 40;
    const std::uint32_t kind = random() % 3;
    const std::uint32_t id = kind == 0   ? 0x700 + node
                             : kind == 1 ? can::kExtended | (random() % 60) << 8 | node
                                         : can::kError | random() % 0x1FF;
    const Time now = line_->now();
    chassis_->on_arrival({std::span(bytes).first(random() % 9), now, now, id}, nobody);
    line_->run(1ms);
  }
  EXPECT_FALSE(chassis_->failure());
  expect_it_drives({.vx = 300});
}

TEST_P(MotorChassisTest, ARecordingIsListenedToOnly) {
  build(Wheels::differential(400));
  std::vector<MotorLink> links;
  for (std::uint8_t node = 10; node < 12; ++node)
    links.push_back({motor(node, MotorTask::kTurns), "motor", kGear});
  MotorChassis listening({.is_canopen = true, .only_listen = true}, Wheels::differential(400),
                         std::move(links));
  listening.stop({}, *std::make_unique<RecordingOutput>());
}

// The messages that show that a motor is running.
std::vector<std::pair<std::uint32_t, std::vector<std::byte>>> signs_of_life(std::uint8_t node) {
  const std::vector<std::byte> zeros(8);
  std::vector<std::byte> closed = zeros;
  closed[4] = std::byte{8};
  return {{odrive_id(node, OdriveCommand::kHeartbeat), closed},
          {odrive_id(node, OdriveCommand::kEncoder), zeros},
          {vesc_id(node, VescPacket::kStatus1), zeros},
          {canopen::kHeartbeat + node, {canopen::kOperational}}};
}

TEST_P(MotorChassisTest, APauseOfARecordingIsNotAFailureOfItsMotors) {
  for (const bool only_listen : {true, false}) {
    std::vector<MotorLink> links;
    for (std::uint8_t node = 10; node < 12; ++node)
      links.push_back({motor(node, MotorTask::kTurns), "motor", kGear});
    MotorChassis chassis({.only_listen = only_listen}, Wheels::differential(400), std::move(links));
    RecordingOutput output;
    chassis.start(Time{1s}, output);
    for (std::uint8_t node = 10; node < 12; ++node)
      for (const auto& [id, bytes] : signs_of_life(node))
        chassis.on_arrival({.bytes = bytes, .first = Time{1s}, .last = Time{1s}, .id = id}, output);
    for (Time now{1s}; now < Time{20s}; now += 10ms) chassis.on_timeout(now, output);
    EXPECT_EQ(chassis.failure().has_value(), !only_listen);
  }
}

TEST_P(MotorChassisTest, WhatItProcessesPassesItsFilter) {
  const auto one = motor(5, MotorTask::kTurns);
  RecordingOutput output;
  one->start(Time{1s}, output);
  const CanFilter wanted = one->wanted_frames();
  const std::vector<std::byte> bytes(8);
  int received = 0;
  int passed = 0;
  const auto try_frame = [&](std::uint32_t id) {
    const bool passes = (id & wanted.mask) == (wanted.id & wanted.mask);
    passed += passes ? 1 : 0;
    if (!one->on_frame({.bytes = bytes, .first = Time{1s}, .last = Time{1s}, .id = id}, output))
      return;
    ++received;
    EXPECT_TRUE(passes) << std::hex << id;
  };
  for (std::uint32_t id = 0; id < 0x800; ++id)
    for (const std::uint32_t flag : {0U, can::kRemote, can::kExtended}) try_frame(id | flag);
  for (std::uint32_t id = 0x800; id < 0x8000; ++id) try_frame(id | can::kExtended);
  EXPECT_GT(received, 0);
  EXPECT_LE(passed, 150) << "of thirty thousand";
}

TEST_P(MotorChassisTest, CommandsAreWorthlessSoonAndTheEndIsNot) {
  const auto one = motor(5, MotorTask::kTurns);
  if (GetParam() == Kind::kCia402) GTEST_SKIP() << "receives no commands before it is enabled";
  RecordingOutput output;
  one->command(1, Time{1s}, output);
  EXPECT_EQ(output.deadlines.back(), Time{1050ms});
  one->stop(output);
  EXPECT_EQ(output.deadlines.back(), tims::kNever);
}

INSTANTIATE_TEST_SUITE_P(Kinds, MotorChassisTest,
                         testing::Values(Kind::kOdrive, Kind::kVesc, Kind::kCia402),
                         [](const auto& kind) {
                           return kind.param == Kind::kOdrive ? "Odrive"
                                  : kind.param == Kind::kVesc ? "Vesc"
                                                              : "Cia402";
                         });

// --- what goes over the bus, byte by byte

TEST(OdriveTest, FramesAreThoseOfItsDocumentation) {
  RecordingOutput output;
  Odrive drive(3, MotorTask::kTurns);
  drive.command(2 * std::numbers::pi, {}, output);
  using testing::ElementsAre;
  ASSERT_EQ(output.frames.size(), 1U);
  EXPECT_EQ(output.frames[0].first, 0x06DU);  // 3 << 5 | 0x0D
  EXPECT_THAT(output.frames[0].second, ElementsAre(0, 0, 0x80, 0x3F, 0, 0, 0, 0));
}

TEST(OdriveTest, IsAskedForItsEncoderWhenItDoesNotReportIt) {
  MotorBus bus;
  auto node = std::make_unique<OdriveEmulator>(3);
  node->sends_encoder = false;
  bus.add(std::move(node));
  std::vector<MotorLink> links;
  links.push_back({std::make_unique<Odrive>(3, MotorTask::kTurns), "motor", 1});
  MotorChassis chassis({}, Wheels({{.drive = 0}}, 1, 0), std::move(links));
  emulator::VirtualLine line(chassis, bus, {.is_bus = true});
  line.start();
  line.run(3s, [&] { return chassis.is_ready(); });
  EXPECT_TRUE(chassis.is_ready());
}

TEST(VescTest, FramesAreThoseOfItsDocumentation) {
  RecordingOutput output;
  Vesc motor({.node = 5, .pole_pairs = 1});
  motor.command(1000 * 2 * std::numbers::pi / 60, {}, output);
  using testing::ElementsAre;
  ASSERT_EQ(output.frames.size(), 1U);
  EXPECT_EQ(output.frames[0].first, 0x80000305U);
  EXPECT_THAT(output.frames[0].second, ElementsAre(0, 0, 0x03, 0xE8));
}

TEST(Cia402Test, StatuswordsAreStates) {
  EXPECT_EQ(cia402_state(0x0637), Cia402State::kOperationEnabled);  // of a real drive: 37 06
  EXPECT_EQ(cia402_state(0x0250), Cia402State::kSwitchOnDisabled);
  EXPECT_EQ(cia402_state(0x0231), Cia402State::kReadyToSwitchOn);
  EXPECT_EQ(cia402_state(0x0233), Cia402State::kSwitchedOn);
  EXPECT_EQ(cia402_state(0x0217), Cia402State::kQuickStopActive);
  EXPECT_EQ(cia402_state(0x0218), Cia402State::kFault);
}

TEST(Cia402Test, AnSdoWriteIsAsTheStandardHasIt) {
  using testing::ElementsAre;
  EXPECT_THAT(numbers(canopen::sdo_write(0x6060, 0, 3, 1)),
              ElementsAre(0x2F, 0x60, 0x60, 0, 3, 0, 0, 0));
  EXPECT_THAT(numbers(canopen::sdo_write(0x6040, 0, 0x0F, 2)),
              ElementsAre(0x2B, 0x40, 0x60, 0, 0x0F, 0, 0, 0));
  EXPECT_THAT(numbers(canopen::sdo_write(0x60FF, 0, 0x12345678, 4)),
              ElementsAre(0x23, 0xFF, 0x60, 0, 0x78, 0x56, 0x34, 0x12));
}

TEST(Cia402Test, EachStartWritesTheFirstObjectAsOftenWithoutAnswer) {
  Cia402 silent({.node = 5});
  const auto writes = [&](Time start) {
    RecordingOutput output;
    silent.start(start, output);
    for (Time now = start; now < start + 10s && !silent.failure(); now += 10ms)
      silent.on_timeout(now, output);
    EXPECT_TRUE(silent.failure());
    return std::ranges::count(output.frames, canopen::kSdoRequest + 5U,
                              [](const auto& frame) { return frame.first; });
  };
  const auto first = writes(Time{1s});
  EXPECT_GT(first, 1);
  EXPECT_EQ(writes(Time{100s}), first);
}

class OneDriveTest : public testing::Test {
 protected:
  void build(std::optional<std::uint16_t> lacks = {}) {
    auto emulated = std::make_unique<Cia402Emulator>(7, kIncrements, kIncrements);
    drive_ = emulated.get();
    drive_->lacks = lacks;
    bus_.add(std::move(emulated));
    std::vector<MotorLink> links;
    links.push_back(
        {std::make_unique<Cia402>(Cia402Settings{
             .node = 7, .increments_of_turn = kIncrements, .velocity_of_turn = kIncrements}),
         "motor of node 7", 1});
    chassis_.emplace(MotorChassisSettings{.is_canopen = true}, Wheels({{.drive = 0}}, 1, 0),
                     std::move(links));
    line_.emplace(*chassis_, bus_, emulator::LineSettings{.is_bus = true, .delay = 100us});
    line_->start();
    line_->run(5s, [&] { return chassis_->is_ready() || chassis_->failure(); });
  }
  // The frames that the drive sends without a request.
  struct Wire final : Output {
    explicit Wire(OneDriveTest& of) : test(of) {}
    void send(std::span<const std::byte> bytes, std::uint32_t id) override {
      RecordingOutput nobody;
      const Time now = test.line_->now();
      test.chassis_->on_arrival({bytes, now, now, id}, nobody);
    }
    OneDriveTest& test;
  };

  MotorBus bus_;
  Cia402Emulator* drive_ = nullptr;
  std::optional<MotorChassis> chassis_;
  std::optional<emulator::VirtualLine> line_;
};

TEST_F(OneDriveTest, IsConfiguredToWatchTheHost) {
  build();
  ASSERT_TRUE(chassis_->is_ready());
  EXPECT_EQ(drive_->object(0x1016, 1), 127U << 16 | 200U);
  EXPECT_EQ(drive_->object(0x6007, 0), 3U);
  EXPECT_EQ(drive_->object(0x1600, 2), 0x60FF0020U);
  EXPECT_EQ(drive_->object(0x1400, 1), 0x207U);
}

TEST_F(OneDriveTest, AnOptionalObjectMayBeMissing) {
  build(0x605A);
  EXPECT_TRUE(chassis_->is_ready());
}

TEST_F(OneDriveTest, ANeededObjectMayNot) {
  build(0x6060);
  ASSERT_TRUE(chassis_->failure());
  EXPECT_THAT(chassis_->failure()->detail(),
              testing::HasSubstr("refuses object 6060:0, abort code 06020000"));
}

TEST_F(OneDriveTest, AFaultIsNamedAndClearedByANewBeginning) {
  build();
  Wire wire(*this);
  drive_->set_fault(0x8611, wire);
  line_->run(100ms);
  ASSERT_TRUE(chassis_->failure());
  EXPECT_THAT(chassis_->failure()->detail(), testing::HasSubstr("reports error 8611"));
  line_->start();
  line_->run(5s, [&] { return chassis_->is_ready(); });
  EXPECT_TRUE(chassis_->is_ready());
}

TEST_F(OneDriveTest, ARestartedDriveIsFoundOut) {
  build();
  Wire wire(*this);
  drive_->restart(wire);
  line_->run(100ms);
  ASSERT_TRUE(chassis_->failure());
  EXPECT_THAT(chassis_->failure()->detail(), testing::HasSubstr("was restarted"));
}

}  // namespace motor_chassis_test
}  // namespace rack::device
