#include "components/devices/camera/visca.h"

#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/camera/ptz_camera.h"
#include "rack/devices/virtual_line.h"

namespace rack::device {
namespace visca_test {

using namespace std::chrono_literals;
using emulator::LineSettings;
using emulator::VirtualLine;

constexpr LineSettings kSerial{
    .has_rate = true, .host_baud = 9600, .device_baud = 9600, .piece = 3};
constexpr LineSettings kUdp{.is_bus = true};

std::vector<std::byte> bytes(std::initializer_list<int> values) {
  std::vector<std::byte> all;
  for (const int value : values) all.push_back(static_cast<std::byte>(value));
  return all;
}

// The first message sent for a command.
std::vector<std::byte> first_command(auto command) {
  Visca visca({});
  struct Keeper : Output {
    std::vector<std::vector<std::byte>> sent;
    void send(std::span<const std::byte> message, std::uint32_t) override {
      sent.emplace_back(message.begin(), message.end());
    }
  } keeper;
  visca.start(Time(1s), keeper);
  const auto where = bytes({0x90, 0x50, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF});
  const auto near = bytes({0x90, 0x50, 0, 0, 0, 0, 0xFF});
  visca.on_arrival({.bytes = where, .last = Time(1s)}, keeper);
  visca.on_arrival({.bytes = near, .last = Time(1s)}, keeper);
  EXPECT_TRUE(visca.is_ready());
  keeper.sent.clear();
  command(visca);
  EXPECT_LE(visca.next_timeout(), Time(1s));
  visca.on_timeout(Time(1s), keeper);
  return keeper.sent.empty() ? std::vector<std::byte>() : keeper.sent.front();
}

// Commands from Sony's command list.
TEST(ViscaTest, CommandsOfTheManual) {
  EXPECT_EQ(first_command([](Visca& v) { v.home(); }), bytes({0x81, 0x01, 0x06, 0x04, 0xFF}));
  EXPECT_EQ(first_command([](Visca& v) { v.move({}, Time(1s)); }),
            bytes({0x81, 0x01, 0x06, 0x01, 0x01, 0x01, 0x03, 0x03, 0xFF}));
  EXPECT_EQ(first_command([](Visca& v) { v.move({.velPan = 9, .velTilt = -9}, Time(1s)); }),
            bytes({0x81, 0x01, 0x06, 0x01, 0x18, 0x14, 0x02, 0x02, 0xFF}));
  EXPECT_EQ(first_command([](Visca& v) {
              v.move_to({.posPan = -10 * std::numbers::pi_v<float> / 180,
                         .posTilt = 10 * std::numbers::pi_v<float> / 180});
            }),
            bytes({0x81, 0x01, 0x06, 0x02, 0x18, 0x14, 0xF, 0xF, 0x7, 0x0, 0, 0, 0x9, 0, 0xFF}));
}

TEST(ViscaTest, AHeadOfUdp) {
  std::vector<std::byte> out;
  const auto message = bytes({0x81, 0x09, 0x04, 0x47, 0xFF});
  visca::append_datagram(out, visca::Kind::kQuestion, 0x01020304, message);
  EXPECT_EQ(out, bytes({0x01, 0x10, 0x00, 0x05, 1, 2, 3, 4, 0x81, 0x09, 0x04, 0x47, 0xFF}));
  ASSERT_TRUE(visca::parse_datagram(out));
  EXPECT_EQ(visca::parse_datagram(out)->number, 0x01020304U);
  for (std::size_t size = 0; size < out.size(); ++size)
    EXPECT_FALSE(visca::parse_datagram(std::span(out).first(size)));
}

TEST(ViscaTest, EverySplitGivesTheSameMessages) {
  const auto stream =
      bytes({0x05, 0x77, 0x90, 0x41, 0xFF, 0x90, 0x50, 1, 2, 3, 4, 0xFF, 0xFF, 0x90, 0x51, 0xFF});
  for (std::size_t cut = 0; cut <= stream.size(); ++cut) {
    ViscaMessages messages;
    std::vector<std::size_t> sizes;
    for (const auto piece : {std::span(stream).first(cut), std::span(stream).subspan(cut)}) {
      messages.add({.bytes = piece});
      while (const auto message = messages.next()) sizes.push_back(message->size());
    }
    EXPECT_EQ(sizes, (std::vector<std::size_t>{3, 7, 3})) << cut;
  }
}

class ViscaDialogue : public testing::TestWithParam<bool> {
 protected:
  LineSettings settings() const { return GetParam() ? kUdp : kSerial; }
};
INSTANTIATE_TEST_SUITE_P(SerialAndUdp, ViscaDialogue, testing::Bool());

TEST_P(ViscaDialogue, ItMovesToItsTargetAndReportsIt) {
  emulator::PtzCamera camera(GetParam());
  Visca driver({.is_datagrams = GetParam()});
  VirtualLine line(driver, camera, settings());
  line.start();
  PtzDriveData data;
  Time recorded;
  ASSERT_TRUE(line.run(2s, [&] { return driver.take(data, recorded); }));
  EXPECT_EQ(data.posPan, 0);
  driver.move_to({.posPan = 0.5F, .posTilt = -0.3F, .posZoom = 40});
  ASSERT_TRUE(line.run(10s, [&] { return driver.take_reached(); }));
  EXPECT_NEAR(camera.pan(), 0.5 * 180 / std::numbers::pi * 14.4, 3);
  driver.take(data, recorded);
  EXPECT_NEAR(data.posPan, 0.5, 0.01);
  EXPECT_NEAR(data.posTilt, -0.3, 0.01);
  EXPECT_NEAR(data.posZoom, 40, 1);
  EXPECT_FALSE(driver.take_reached());
  EXPECT_EQ(driver.refused(), 0U);

  for (int i = 0; i < 10; ++i) {
    driver.move({.velPan = -0.5F, .velZoom = 10}, line.now());
    line.run(100ms);
  }
  ASSERT_TRUE(driver.take(data, recorded));
  EXPECT_LT(data.posPan, 0.2);
  EXPECT_GT(data.posZoom, 45);
  EXPECT_FALSE(camera.stands());
  line.stop_host();
  line.run(100ms);
  EXPECT_TRUE(camera.stands());
}

TEST_P(ViscaDialogue, StandsWhenNobodyMovesItAnyMore) {
  emulator::PtzCamera camera(GetParam());
  Visca driver({.is_datagrams = GetParam()});
  VirtualLine line(driver, camera, settings());
  line.start();
  ASSERT_TRUE(line.run(2s, [&] { return driver.is_ready(); }));
  for (int i = 0; i < 5; ++i) {
    driver.move({.velPan = 0.5F, .velTilt = 0.1F, .velZoom = 5}, line.now());
    line.run(50ms);
  }
  EXPECT_FALSE(camera.stands());
  line.run(80ms);  // the last command is 130 ms old
  EXPECT_FALSE(camera.stands());
  EXPECT_FALSE(driver.take_overdue());
  line.run(100ms);
  EXPECT_TRUE(camera.stands());
  EXPECT_TRUE(driver.take_overdue());
  // A target position is reached without repetition, independent of the duration.
  driver.move({.velPan = 0.5F}, line.now());
  driver.move_to({.posPan = -0.5F});
  EXPECT_TRUE(line.run(10s, [&] { return driver.take_reached(); }));
  EXPECT_FALSE(driver.take_overdue());
}

TEST_P(ViscaDialogue, ALostAnswerIsAskedForAgain) {
  emulator::PtzCamera camera(GetParam());
  Visca driver({.is_datagrams = GetParam()});
  VirtualLine line(driver, camera, settings());
  std::mt19937 random(1);
  line.set_lose(
      [&](bool from_host, std::span<const std::byte>) { return !from_host && random() % 5 == 0; });
  line.start();
  int taken = 0;
  PtzDriveData data;
  Time recorded;
  line.run(60s, [&] {
    taken += driver.take(data, recorded) ? 1 : 0;
    if (driver.failure()) line.start_host();
    return false;
  });
  EXPECT_GT(taken, 100);
}

TEST_P(ViscaDialogue, AMissingAnswerIsReported) {
  emulator::PtzCamera camera(GetParam());
  Visca driver({.is_datagrams = GetParam()});
  VirtualLine line(driver, camera, settings());
  line.set_lose([](bool from_host, std::span<const std::byte>) { return from_host; });
  line.start();
  EXPECT_TRUE(line.run(5s, [&] { return driver.failure().has_value(); }));
  EXPECT_THAT(driver.failure()->detail(), testing::HasSubstr("does not answer"));
}

TEST(ViscaTest, NoiseBreaksNothing) {
  std::mt19937 random(1);
  emulator::PtzCamera camera;
  Visca driver({});
  VirtualLine line(driver, camera, kSerial);
  line.start();
  for (int i = 0; i < 500; ++i) {
    std::vector<std::byte> noise(random() % 40);
    for (std::byte& byte : noise) byte = static_cast<std::byte>(random() % 256);
    line.disturb(noise);
    line.run(50ms);
    if (driver.failure()) line.start_host();
  }
  PtzDriveData data;
  Time recorded;
  driver.take(data, recorded);
  if (driver.failure()) line.start_host();
  EXPECT_TRUE(line.run(2s, [&] { return driver.take(data, recorded); }));
}

TEST(ViscaTest, NumbersThatAreNoneDoNotMoveIt) {
  Visca driver({});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  driver.move({.velPan = nan, .velTilt = nan, .velZoom = nan}, Time(1s));
  driver.move_to({.posPan = nan, .posTilt = 1e30F, .posZoom = nan});
}

}  // namespace visca_test
}  // namespace rack::device
