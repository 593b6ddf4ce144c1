// The dialogues of receivers, gyros, compasses and clocks with their emulators, on a simulated line
// with a virtual clock: real rates, lost answers, wrong rates.
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/positioning/cmps03.h"
#include "components/devices/positioning/cmps03_emulator.h"
#include "components/devices/positioning/dcf77_emulator.h"
#include "components/devices/positioning/nmea_emulator.h"
#include "components/devices/positioning/nmea_receiver.h"
#include "components/devices/positioning/ublox.h"
#include "components/devices/positioning/ublox_emulator.h"
#include "components/devices/positioning/xsens_emulator.h"
#include "rack/devices/virtual_line.h"

namespace rack::device::emulator {
namespace navigation_test {

using namespace std::chrono_literals;

constexpr double kDegree = std::numbers::pi / 180;

// Takes all data sets within a time.
template <class Data, class Dialog>
std::vector<Data> receive(VirtualLine& line, Dialog& dialogue, Duration how_long,
                          std::vector<Time>* times = nullptr) {
  std::vector<Data> all;
  line.run(how_long, [&] {
    Data data;
    Time recorded;
    if (dialogue.take(data, recorded)) {
      all.push_back(data);
      if (times != nullptr) times->push_back(recorded);
    }
    return dialogue.failure().has_value();
  });
  return all;
}

// --- satellite receivers

TEST(NmeaEmulatorTest, ACourseWithFixesGainedAndLost) {
  NmeaReceiver receiver({});
  NmeaEmulator device;
  VirtualLine line(receiver, device,
                   {.has_rate = true, .host_baud = 4800, .device_baud = 4800, .piece = 8});
  line.start();
  const Time began = line.now();
  std::vector<Time> times;
  const auto all = receive<GpsData>(line, receiver, 130s, &times);
  ASSERT_GE(all.size(), 129U);
  const GpsCourse course;
  int lost = 0;
  for (std::size_t i = 1; i < all.size(); ++i) {
    const auto point = course.at(std::chrono::seconds(i));
    EXPECT_EQ(all[i].mode != gps_mode::kInvalid, point.is_fixed) << i;
    EXPECT_EQ(all[i].utcTime, 1767225600 + static_cast<i64>(i));
    EXPECT_NEAR(static_cast<double>((times[i] - began).count()),
                (static_cast<double>(i) + 0.08) * 1e9, 5e6);
    if (!point.is_fixed) ++lost;
    if (!point.is_fixed) continue;
    EXPECT_NEAR(all[i].latitude, point.latitude * kDegree, 1e-8);
    EXPECT_NEAR(all[i].longitude, point.longitude * kDegree, 1e-8);
    EXPECT_NEAR(all[i].heading, point.course * kDegree, 1e-3);
    EXPECT_NEAR(all[i].speed, 2000, 2);
  }
  EXPECT_EQ(lost, 3 + 5 + 5);
}

TEST(NmeaEmulatorTest, AWrongRateIsReported) {
  NmeaReceiver receiver({});
  NmeaEmulator device;
  VirtualLine line(receiver, device, {.has_rate = true, .host_baud = 4800, .device_baud = 9600});
  line.start();
  EXPECT_TRUE(receive<GpsData>(line, receiver, 20s).empty());
  ASSERT_TRUE(receiver.failure());
  EXPECT_THAT(receiver.failure()->detail(), testing::HasSubstr("not NMEA at 4800"));
}

struct UbloxCase {
  int generation;
  std::uint32_t device_baud;
  std::uint32_t wanted_baud;
  std::uint32_t expected_baud;
};

void PrintTo(const UbloxCase& one, std::ostream* out) {
  *out << "generation " << one.generation << " at " << one.device_baud;
}

class UbloxTest : public testing::TestWithParam<UbloxCase> {};

TEST_P(UbloxTest, IsFoundConfiguredAndReceived) {
  const UbloxCase& with = GetParam();
  Ublox receiver({.baud = with.wanted_baud, .period = 500ms});
  UbloxEmulator device({.generation = with.generation, .baud = with.device_baud});
  VirtualLine line(
      receiver, device,
      {.has_rate = true, .host_baud = 38400, .device_baud = with.device_baud, .piece = 16});
  line.start();
  ASSERT_TRUE(line.run(30s, [&] { return receiver.is_ready() || receiver.failure(); }));
  ASSERT_FALSE(receiver.failure()) << receiver.failure()->message();
  EXPECT_EQ(receiver.is_old(), with.generation < 9);
  EXPECT_EQ(line.host_baud(), with.expected_baud);
  EXPECT_EQ(line.device_baud(), with.expected_baud);
  EXPECT_EQ(device.period(), 500ms);
  const auto all = receive<GpsData>(line, receiver, 20s);
  EXPECT_NEAR(static_cast<double>(all.size()), 40, 2);
  EXPECT_EQ(all.back().var.x, 1100);
  EXPECT_EQ(all.back().mode, gps_mode::k3d);
  EXPECT_NEAR(all.back().speed, 2000, 1);
}

TEST_P(UbloxTest, LostAnswersAreAskedForAgain) {
  const UbloxCase& with = GetParam();
  for (int lost = 0; lost < 8; ++lost) {
    Ublox receiver({.baud = with.wanted_baud});
    UbloxEmulator device({.generation = with.generation, .baud = with.device_baud});
    VirtualLine line(receiver, device,
                     {.has_rate = true, .host_baud = 38400, .device_baud = with.device_baud});
    int number = 0;
    line.set_lose([&](bool from_host, std::span<const std::byte> bytes) {
      const bool is_answer = !from_host && bytes.size() < 60;
      return (from_host || is_answer) && number++ == lost;
    });
    line.start();
    line.run(60s, [&] { return receiver.is_ready() || receiver.failure(); });
    EXPECT_TRUE(receiver.is_ready()) << lost;
  }
}

INSTANTIATE_TEST_SUITE_P(Receivers, UbloxTest,
                         testing::Values(UbloxCase{9, 38400, 0, 38400}, UbloxCase{8, 9600, 0, 9600},
                                         UbloxCase{10, 115200, 0, 115200},
                                         UbloxCase{9, 38400, 115200, 115200},
                                         UbloxCase{8, 9600, 38400, 38400},
                                         UbloxCase{9, 115200, 115200, 115200}),
                         [](const testing::TestParamInfo<UbloxCase>& with) {
                           return "M" + std::to_string(with.param.generation) + "At" +
                                  std::to_string(with.param.device_baud) + "To" +
                                  std::to_string(with.param.expected_baud);
                         });

TEST(UbloxEmulatorTest, ASilentLineIsReported) {
  Ublox receiver({});
  UbloxEmulator device;
  VirtualLine line(receiver, device, {.has_rate = true, .host_baud = 38400, .device_baud = 38400});
  line.set_lose([](bool, std::span<const std::byte>) { return true; });
  line.start();
  line.run(60s, [&] { return receiver.failure().has_value(); });
  ASSERT_TRUE(receiver.failure());
  EXPECT_THAT(receiver.failure()->detail(), testing::HasSubstr("no receiver answers"));
}

TEST(UbloxEmulatorTest, ADeviceThatReceivesNothingIsReported) {
  Ublox receiver({});
  UbloxEmulator device;
  VirtualLine line(receiver, device, {.has_rate = true, .host_baud = 38400, .device_baud = 38400});
  line.set_lose([](bool from_host, std::span<const std::byte>) { return from_host; });
  line.start();
  line.run(60s, [&] { return receiver.failure().has_value(); });
  ASSERT_TRUE(receiver.failure());
  EXPECT_THAT(receiver.failure()->detail(), testing::HasSubstr("check the wiring of its input"));
}

// --- gyros

class XsensDialogueTest : public testing::TestWithParam<bool> {};

TEST_P(XsensDialogueTest, IsSetAndMeasuresAHundredTimesASecond) {
  Xsens gyro({.mounting = XsensMounting::kLabelUp});
  XsensEmulator device({.is_old = GetParam()});
  VirtualLine line(gyro, device,
                   {.has_rate = true, .host_baud = 115200, .device_baud = 115200, .piece = 5});
  line.start();
  ASSERT_TRUE(line.run(5s, [&] { return gyro.is_ready() || gyro.failure(); }));
  ASSERT_FALSE(gyro.failure()) << gyro.failure()->message();
  std::vector<Time> times;
  const auto all = receive<GyroData>(line, gyro, 10s, &times);
  EXPECT_NEAR(static_cast<double>(all.size()), 1000, 3);
  for (std::size_t i = 1; i < all.size(); ++i) {
    EXPECT_NEAR(all[i].wYaw, -0.2, 1e-6);
    EXPECT_NEAR(all[i].pitch, 0, 1e-5);
    EXPECT_NEAR(std::remainder(all[i].yaw - all[i - 1].yaw, 2 * std::numbers::pi), -0.002, 1e-4);
    EXPECT_NEAR(std::hypot(all[i].aY, all[i].aZ), 9810, 1);
    EXPECT_NEAR(static_cast<double>((times[i] - times[i - 1]).count()), 10e6, 1e5) << i;
  }
}

TEST_P(XsensDialogueTest, LostAnswersAreAskedForAgain) {
  for (int lost = 0; lost < 8; ++lost) {
    Xsens gyro({});
    XsensEmulator device({.is_old = GetParam()});
    VirtualLine line(gyro, device, {.has_rate = true, .host_baud = 115200, .device_baud = 115200});
    int number = 0;
    line.set_lose([&](bool from_host, std::span<const std::byte> bytes) {
      return (from_host || bytes.size() < 50) && number++ == lost;
    });
    line.start();
    line.run(20s, [&] { return (gyro.is_ready() && device.is_measuring()) || gyro.failure(); });
    EXPECT_FALSE(gyro.failure()) << lost;
    EXPECT_GT(receive<GyroData>(line, gyro, 1s).size(), 90U) << lost;
  }
}

TEST_P(XsensDialogueTest, AnotherDeviceIsRefusedByItsNumber) {
  const auto refusal = [](const std::string& wanted, bool is_received = true) -> std::string {
    Xsens gyro({.serial_number = wanted});
    XsensEmulator device({.is_old = GetParam(), .id = 0x0378ABCD});
    VirtualLine line(gyro, device, {});
    line.set_lose([&](bool from_host, auto) { return from_host && !is_received; });
    line.start();
    EXPECT_TRUE(line.run(10s, [&] { return gyro.is_ready() || gyro.failure(); }));
    return gyro.failure() ? gyro.failure()->detail() : "";
  };
  EXPECT_EQ(refusal("0378ABCE"), "this device has serial number 0378abcd; required: 0378ABCE");
  EXPECT_EQ(refusal("0378ABCD"), "");
  EXPECT_EQ(refusal(""), "");
  EXPECT_EQ(refusal("0378ABCD", false), "this device reports no serial number; required: 0378ABCD");
}

INSTANTIATE_TEST_SUITE_P(Generations, XsensDialogueTest, testing::Bool());

TEST(XsensEmulatorTest, ADeviceThatReceivesNothingIsStillRead) {
  Xsens gyro({});
  XsensEmulator device({.is_old = true});
  VirtualLine line(gyro, device, {.has_rate = true, .host_baud = 115200, .device_baud = 115200});
  line.set_lose([](bool from_host, std::span<const std::byte>) { return from_host; });
  line.start();
  EXPECT_GT(receive<GyroData>(line, gyro, 5s).size(), 300U);
  EXPECT_FALSE(gyro.failure());
}

TEST(XsensEmulatorTest, AWrongRateIsReported) {
  Xsens gyro({.baud = 9600});
  XsensEmulator device;
  VirtualLine line(gyro, device, {.has_rate = true, .host_baud = 9600, .device_baud = 115200});
  line.start();
  EXPECT_TRUE(receive<GyroData>(line, gyro, 10s).empty());
  ASSERT_TRUE(gyro.failure());
  EXPECT_THAT(gyro.failure()->detail(), testing::HasSubstr("at 9600 baud"));
}

// --- a compass

TEST(Cmps03EmulatorTest, TurnsAndIsCalibrated) {
  Cmps03 compass({});
  Cmps03Emulator device;
  VirtualLine line(compass, device, {.has_rate = true, .host_baud = 57600, .device_baud = 57600});
  line.start();
  const auto all = receive<CompassData>(line, compass, 10s);
  EXPECT_NEAR(static_cast<double>(all.size()), 100, 1);
  EXPECT_NEAR(all.back().orientation - all.front().orientation, 15 * 9.9 * kDegree, 0.05);
  int direction = 0;
  compass.request_calibration(true, false, line.now());
  EXPECT_EQ(compass.take_step(direction), Cmps03::Step::kAlign);
  for (int i = 1; i <= 4; ++i) {
    compass.request_calibration(true, true, line.now());
    line.run(1s);
    EXPECT_EQ(compass.take_step(direction), i < 4 ? Cmps03::Step::kConfirmed : Cmps03::Step::kDone);
    EXPECT_EQ(device.directions(), i);
  }
}

// --- clocks

class Dcf77EmulatorTest : public testing::TestWithParam<Dcf77Kind> {};

TEST_P(Dcf77EmulatorTest, ReportsTheBeginOfEachSecond) {
  Dcf77 clock(GetParam());
  Dcf77Emulator device({.kind = GetParam()});
  VirtualLine line(clock, device,
                   {.has_rate = true, .host_baud = 9600, .device_baud = 9600, .piece = 4});
  line.start();
  const Time began = line.now();
  std::vector<Time> times;
  const auto all = receive<ClockData>(line, clock, 60500ms, &times);
  ASSERT_EQ(all.size(), 60U);
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].utcTime, 1767225601 + static_cast<i64>(i));
    EXPECT_EQ(all[i].syncMode, i >= 2 ? 1 : 0);
    EXPECT_NEAR(static_cast<double>((times[i] - began).count()), (static_cast<double>(i) + 1) * 1e9,
                8e6);
  }
}

// At both changes of daylight saving time, each second is reported once.
TEST_P(Dcf77EmulatorTest, SummerBeginsAndEnds) {
  for (const std::chrono::seconds change : {1774746000s, 1792890000s}) {  // 2026
    for (std::chrono::seconds utc = change - 3s; utc < change + 3s; utc += 1s) {
      std::string telegram = dcf77_telegram(GetParam(), utc, true);
      if (telegram.back() == '\r') telegram.pop_back();
      ClockData data;
      ASSERT_TRUE(GetParam() == Dcf77Kind::kMeinberg ? parse_meinberg(telegram, data)
                                                     : parse_emc_pro(telegram, data))
          << telegram;
      EXPECT_EQ(data.utcTime, utc.count());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, Dcf77EmulatorTest,
                         testing::Values(Dcf77Kind::kMeinberg, Dcf77Kind::kEmcPro));

}  // namespace navigation_test
}  // namespace rack::device::emulator
