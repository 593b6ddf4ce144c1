#include "components/devices/chassis/mavlink.h"

#include <cmath>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/chassis/mavlink_vehicle.h"
#include "components/devices/chassis/rover.h"
#include "rack/devices/virtual_line.h"

namespace rack::device {
namespace mavlink_test {

using namespace std::chrono_literals;

std::vector<std::byte> bytes_of(std::string_view hex) {
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes.push_back(static_cast<std::byte>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16)));
  return bytes;
}

std::vector<mavlink::Packet> packets_in(std::initializer_list<std::span<const std::byte>> pieces) {
  mavlink::Packets packets;
  mavlink::Packet packet;
  std::vector<mavlink::Packet> found;
  for (const auto piece : pieces) {
    packets.add({.bytes = piece});
    while (packets.next(packet)) found.push_back(packet);
  }
  return found;
}

// Packets from the tests of three other implementations.
TEST(MavlinkTest, PacketsOfOthersAreRead) {
  const auto version1 = bytes_of("FE09EF0102000500000002035903031F50");
  const auto version2 = bytes_of("FD090000EF010100000005000000020359030310F0");
  const auto rover = bytes_of(
      "FD090000072A96000000440000000503"
      "2D0D027EFD");
  const auto command =
      bytes_of("FD1E00000000324C00000000E64200409C45" + std::string(40, '0') + "FF01BCC3");
  const auto found = packets_in({version1, version2, rover, command});
  ASSERT_EQ(found.size(), 4U);
  EXPECT_EQ(found[0].component, 2);
  EXPECT_EQ(found[1].component, 1);
  EXPECT_EQ(found[2].system, 42);
  EXPECT_EQ(found[2].number<std::uint32_t>(0), 68U);
  EXPECT_EQ(found[3].message, mavlink::Message::kCommand);
  EXPECT_EQ(found[3].number<std::uint16_t>(28), 511);
  EXPECT_EQ(found[3].real(0), 115);
  EXPECT_EQ(found[3].real(4), 5000);
}

TEST(MavlinkTest, APacketIsWrittenAsOthersWriteIt) {
  mavlink::Writer writer(mavlink::Message::kHeartbeat, 239, 1, 1);
  writer.put(std::uint32_t{5}).put(std::uint8_t{2}).put(std::uint8_t{3});
  writer.put(std::uint8_t{0x59}).put(std::uint8_t{3}).put(std::uint8_t{3});
  const auto bytes = writer.finish();
  EXPECT_EQ(std::vector(bytes.begin(), bytes.end()),
            bytes_of("FD090000EF010100000005000000020359030310F0"));
}

std::vector<std::byte> recorded_stream() {
  struct RecordingOutput final : Output {
    void send(std::span<const std::byte> bytes, std::uint32_t) override {
      received.insert(received.end(), bytes.begin(), bytes.end());
    }
    std::vector<std::byte> received;
  } output;
  RoverEmulator rover;
  rover.start(Time(100s), output);
  for (int i = 0; i < 3; ++i) rover.on_timeout(rover.next_timeout(), output);
  return output.received;
}

TEST(MavlinkTest, EverySplitAndEveryBeginning) {
  const auto stream = recorded_stream();
  const std::span all(stream);
  const std::size_t count = packets_in({all}).size();
  EXPECT_EQ(count, 11U);
  for (std::size_t cut = 0; cut < stream.size(); ++cut) {
    EXPECT_EQ(packets_in({all.first(cut), all.subspan(cut)}).size(), count) << cut;
    EXPECT_GE(packets_in({all.subspan(cut), all, all}).size(), 2 * count - 8) << cut;
  }
}

TEST(MavlinkTest, AFlippedBitCostsSomePacketsAndIsNoOther) {
  const auto stream = recorded_stream();
  const std::size_t count = packets_in({stream}).size();
  for (std::size_t bit = 0; bit < stream.size() * 8; ++bit) {
    auto broken = stream;
    broken[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    const std::size_t found = packets_in({broken, stream, stream}).size();
    EXPECT_LT(found, 3 * count) << bit;
    EXPECT_GE(found, 3 * count - 9) << bit;
  }
}

TEST(MavlinkTest, NoiseBreaksNothing) {
  std::mt19937 random(1);
  std::vector<std::byte> noise(100000);
  for (std::byte& byte : noise) byte = static_cast<std::byte>(0xFC + random() % 4);
  for (std::size_t i = 0; i < noise.size(); i += 1000)
    packets_in({std::span(noise).subspan(i, 1000)});
}

class MavlinkVehicleTest : public testing::Test {
 protected:
  void begin(const MavlinkSettings& settings) {
    vehicle_.emplace(settings);
    line_.emplace(*vehicle_, rover_, emulator::LineSettings{.delay = 2ms});
    line_->start();
    ASSERT_TRUE(line_->run(10s, [&] { return vehicle_->take(data_, recorded_); }));
  }
  static MavlinkSettings armed() { return {.arms = true, .mode = RoverEmulator::kGuided}; }

  RoverEmulator rover_;
  std::optional<MavlinkVehicle> vehicle_;
  std::optional<emulator::VirtualLine> line_;
  ChassisData data_;
  Time recorded_{};
};

TEST_F(MavlinkVehicleTest, ArmsAndDrives) {
  for (const bool odometry : {false, true}) {
    rover_ = RoverEmulator();
    rover_.sends_odometry = odometry;
    begin(armed());
    line_->run(3s);
    EXPECT_TRUE(rover_.is_armed());
    EXPECT_TRUE(vehicle_->is_armed());
    EXPECT_EQ(rover_.intervals(), 5);
    vehicle_->take(data_, recorded_);
    const double heading = rover_.body().pose().rho;
    const double distance_before = rover_.body().left_distance() + rover_.body().right_distance();
    vehicle_->drive({.vx = 800, .omega = 0.3F}, line_->now());
    double x = 0;
    double turned = 0;
    for (int i = 0; i < 40; ++i) {
      ASSERT_TRUE(line_->run(1s, [&] { return vehicle_->take(data_, recorded_); }));
      x += static_cast<double>(data_.deltaX.raw());
      turned += static_cast<double>(data_.deltaRho.raw());
    }
    EXPECT_NEAR(data_.vx.raw(), 800, 1);
    EXPECT_NEAR(data_.vy.raw(), 0, 1);
    EXPECT_NEAR(data_.omega.raw(), 0.3, 1e-3);
    EXPECT_FLOAT_EQ(data_.battery.raw(), 12.6F);
    EXPECT_NEAR(
        x, (rover_.body().left_distance() + rover_.body().right_distance() - distance_before) / 2,
        10);
    EXPECT_NEAR(turned, rover_.body().pose().rho - heading, 0.01);
  }
}

TEST_F(MavlinkVehicleTest, DoesNotArmUnlessConfigured) {
  begin({});
  line_->run(5s);
  vehicle_->drive({.vx = 800}, line_->now());
  line_->run(2s);
  EXPECT_FALSE(rover_.is_armed());
  EXPECT_TRUE(rover_.body().stands());
}

TEST_F(MavlinkVehicleTest, OtherClassesHaveTheirData) {
  begin({});
  line_->run(1s);
  GpsData gps;
  GyroData gyro;
  PositionData position;
  ASSERT_TRUE(vehicle_->take_gps(gps, recorded_));
  ASSERT_TRUE(vehicle_->take_gyro(gyro, recorded_));
  ASSERT_TRUE(vehicle_->take_position(position, recorded_));
  EXPECT_EQ(gps.mode, gps_mode::k3d);
  EXPECT_NEAR(gps.latitude.raw() * 180 / 3.14159265358979, 52.3791234, 1e-7);
  EXPECT_EQ(gps.altitude.raw(), 55250);
  EXPECT_EQ(gps.speed.raw(), 1500);
  EXPECT_NEAR(gps.heading.raw(), 1.5708, 1e-4);
  EXPECT_EQ(gps.satelliteNum, 11);
  EXPECT_FLOAT_EQ(gps.pdop, 1.21F);
  EXPECT_EQ(gps.utcTime.raw(), 1700000000);
  EXPECT_FLOAT_EQ(gyro.roll.raw(), 0.01F);
  EXPECT_FLOAT_EQ(gyro.pitch.raw(), -0.02F);
  EXPECT_EQ(position.pos.z.raw(), -500);
  EXPECT_FALSE(vehicle_->take_gps(gps, recorded_));
}

// Unknown values are NaN: unknown angular rates become 0, unknown angles make the message invalid.
TEST_F(MavlinkVehicleTest, WhatItDoesNotKnowIsNoData) {
  begin({});
  line_->run(1s);
  GyroData gyro;
  PositionData position;
  struct Nobody final : Output {
    void send(std::span<const std::byte>, std::uint32_t) override {}
  } nobody;
  // Roll, pitch, yaw, and their rates.
  const auto takes = [&](const std::array<double, 6>& attitude) {
    (void)vehicle_->take_gyro(gyro, recorded_);
    mavlink::Writer writer(mavlink::Message::kAttitude, 0, RoverEmulator::kSystem, 1);
    writer.put(std::uint32_t{0});
    for (const double value : attitude) writer.put_real(value);
    vehicle_->on_arrival({.bytes = writer.finish()}, nobody);
    return vehicle_->take_gyro(gyro, recorded_);
  };
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < 3; ++i) {
    std::array<double, 6> attitude{0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
    attitude.at(i) = kUnknown;
    EXPECT_FALSE(takes(attitude));
  }
  EXPECT_TRUE(takes({0.1, 0.2, 0.3, kUnknown, kUnknown, std::numeric_limits<double>::infinity()}));
  EXPECT_FLOAT_EQ(gyro.yaw.raw(), 0.3F);
  EXPECT_EQ(gyro.wRoll.raw(), 0);
  EXPECT_EQ(gyro.wPitch.raw(), 0);
  EXPECT_EQ(gyro.wYaw.raw(), 0);
  EXPECT_FALSE(takes({kUnknown, kUnknown, kUnknown, 0, 0, 0}));
  line_->run(1s);
  ASSERT_TRUE(vehicle_->take_position(position, recorded_));
  EXPECT_TRUE(std::isfinite(position.pos.phi.raw()) && std::isfinite(position.pos.psi.raw()));
}

TEST_F(MavlinkVehicleTest, StandsWhenItIsLeftAndWhenItsHostIsGone) {
  begin(armed());
  line_->run(3s);
  vehicle_->drive({.vx = 800}, line_->now());
  line_->run(20s);
  EXPECT_FALSE(rover_.body().must_stop());
  line_->stop_host();
  line_->run(20ms);
  EXPECT_TRUE(rover_.body().must_stop());
  EXPECT_FALSE(rover_.is_armed());

  begin(armed());
  line_->run(3s);
  vehicle_->drive({.vx = 800}, line_->now());
  line_->run(1s);
  EXPECT_FALSE(rover_.body().must_stop());
  line_->set_lose([](bool, std::span<const std::byte>) { return true; });
  line_->run(3200ms);
  EXPECT_TRUE(rover_.body().must_stop());
  line_->run(1500ms, [&] { return vehicle_->failure().has_value(); });
  ASSERT_TRUE(vehicle_->failure());
  EXPECT_THAT(vehicle_->failure()->detail(), testing::HasSubstr("stopped sending heartbeats"));
}

TEST_F(MavlinkVehicleTest, AnotherSystemIsNotItsVehicle) {
  vehicle_.emplace(MavlinkSettings{.system = 9});
  line_.emplace(*vehicle_, rover_, emulator::LineSettings{});
  line_->start();
  line_->run(5s);
  EXPECT_FALSE(vehicle_->is_ready());
}

}  // namespace mavlink_test
}  // namespace rack::device
