#include "components/devices/scanners/hokuyo.h"

#include <cmath>
#include <fstream>
#include <numbers>
#include <random>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/scanners/hokuyo_emulator.h"
#include "rack/devices/virtual_line.h"

namespace rack::device {
namespace hokuyo_test {

using namespace std::chrono_literals;
using emulator::HokuyoLanguage;
using emulator::VirtualLine;

std::vector<std::vector<std::uint16_t>> recorded_scans() {
  std::ifstream file(DEVICE_DATA "/hokuyo/exp1-80-scans.dat");
  std::ostringstream text;
  text << file.rdbuf();
  return emulator::scans_of_log(text.str(), 1000);
}

emulator::LineSettings serial_line(std::uint32_t device_baud) {
  return {.has_rate = true, .host_baud = 115200, .device_baud = device_baud};
}

TEST(HokuyoTest, FindsAScannerAtAnyRateAndMeasures) {
  for (const std::uint32_t rate : {19200U, 38400U, 57600U, 115200U, 500000U}) {
    emulator::Hokuyo scanner({.baud = rate});
    Hokuyo driver({});
    VirtualLine line(driver, scanner, serial_line(rate));
    line.start();
    EXPECT_TRUE(line.run(10s, [&] { return driver.is_ready() || driver.failure(); })) << rate;
    ASSERT_TRUE(driver.is_ready()) << rate;
    EXPECT_EQ(scanner.baud(), 115200U);
    EXPECT_EQ(line.host_baud(), 115200U);
    EXPECT_FALSE(driver.is_scip1());
    EXPECT_EQ(driver.serial_number(), "H0614967");
    LadarData scan;
    Time recorded;
    EXPECT_TRUE(line.run(1s, [&] { return driver.take(scan, recorded); }));
    EXPECT_EQ(scan.points.size(), 228U);
  }
}

// Runs the dialogue; returns the reason of the failure, or an empty text.
std::string refusal(const std::string& wanted, HokuyoLanguage language = HokuyoLanguage::kScip2) {
  emulator::Hokuyo scanner({.language = language, .serial_number = "H0614967"});
  Hokuyo driver({.serial_number = wanted});
  VirtualLine line(driver, scanner, serial_line(19200));
  line.start();
  EXPECT_TRUE(line.run(20s, [&] { return driver.is_ready() || driver.failure(); }));
  EXPECT_FALSE(driver.failure() && scanner.measures()) << "it received a command to measure";
  return driver.failure() ? driver.failure()->detail() : "";
}

TEST(HokuyoTest, AnotherScannerIsRefusedByItsNumber) {
  EXPECT_EQ(refusal("H0614968"), "this scanner has serial number H0614967; required: H0614968");
  EXPECT_EQ(refusal("H0614967"), "");
  EXPECT_EQ(refusal("h0614967"), "");
  EXPECT_EQ(refusal("H0614967", HokuyoLanguage::kScip1First), "");
  EXPECT_EQ(refusal("H0614967", HokuyoLanguage::kScip1Only),
            "this scanner reports no serial number; required: H0614967");
  EXPECT_EQ(refusal("", HokuyoLanguage::kScip1Only), "");
}

TEST(HokuyoTest, SeesTheRoom) {
  const emulator::Room room;
  emulator::Hokuyo scanner({.sight = room});
  Hokuyo driver({.cluster = 1, .intensities = true});
  VirtualLine line(driver, scanner, {});
  line.start();
  LadarData scan;
  Time recorded;
  ASSERT_TRUE(line.run(10s, [&] { return driver.take(scan, recorded); }));
  ASSERT_EQ(scan.points.size(), 682U);
  for (const LadarPoint& point : scan.points) {
    EXPECT_EQ(point.type, ladar_point::kUnknown);
    EXPECT_NEAR(point.distance, room.distance(point.angle), 3) << point.angle;
    EXPECT_GT(point.intensity, 1000);
  }
  EXPECT_LT(scan.points.front().angle, scan.points.back().angle);
}

TEST(HokuyoTest, AScannerOfScip1IsSwitchedWhereItCanBe) {
  emulator::Hokuyo scanner({.language = HokuyoLanguage::kScip1First});
  Hokuyo driver({});
  VirtualLine line(driver, scanner, serial_line(19200));
  line.start();
  EXPECT_TRUE(line.run(10s, [&] { return driver.is_ready(); }));
  EXPECT_FALSE(driver.is_scip1());
}

TEST(HokuyoTest, AnOldScannerIsAskedScanByScan) {
  const emulator::Room room;
  emulator::Hokuyo scanner({.language = HokuyoLanguage::kScip1Only, .sight = room});
  Hokuyo driver({.start_angle = 120 * std::numbers::pi / 180});
  VirtualLine line(driver, scanner, serial_line(19200));
  line.start();
  ASSERT_TRUE(line.run(10s, [&] { return driver.is_ready(); }));
  EXPECT_TRUE(driver.is_scip1());
  EXPECT_EQ(scanner.baud(), 115200U);
  LadarData scan;
  Time recorded;
  int scans = 0;
  line.run(5s, [&] {
    scans += driver.take(scan, recorded) ? 1 : 0;
    return false;
  });
  // 476 characters are 41 ms at this rate.
  EXPECT_NEAR(scans, 5000 / 42.2, 3);
  ASSERT_EQ(scan.points.size(), 228U);
  for (const LadarPoint& point : scan.points)
    EXPECT_NEAR(point.distance, std::min(4095.0, room.distance(point.angle)), 100) << point.angle;
}

// The numbers in the README of the capture.
TEST(HokuyoTest, RecordedScansArriveAsTheyWere) {
  const auto recorded_distances = recorded_scans();
  ASSERT_EQ(recorded_distances.size(), 80U);
  emulator::Hokuyo scanner({.baud = 115200, .scans = recorded_distances});
  Hokuyo driver({.cluster = 1});
  VirtualLine line(driver, scanner, {.piece = 37});
  line.start();
  LadarData scan;
  Time recorded;
  Time before{};
  std::size_t points = 0;
  std::size_t codes = 0;
  for (std::size_t i = 0; i < 80; ++i) {
    ASSERT_TRUE(line.run(1s, [&] { return driver.take(scan, recorded); }));
    ASSERT_EQ(scan.points.size(), 682U);
    for (std::size_t step = 0; step < 682; ++step) {
      const LadarPoint& point = scan.points[681 - step];
      const int distance = recorded_distances[i][step];
      ++points;
      codes += point.distance == 0 ? 1U : 0U;
      ASSERT_EQ(point.distance, distance < 20 ? 0 : distance);
      ASSERT_EQ(point.type == ladar_point::kInvalid, distance < 20);
    }
    // The clock of the scanner overflows during this time.
    if (i > 0) {
      EXPECT_EQ(recorded - before, 100ms) << i;
    }
    before = recorded;
  }
  EXPECT_EQ(points, 54'560U);
  EXPECT_EQ(codes, 32'811U);
}

TEST(HokuyoTest, LostAnswersAreAskedForAgain) {
  for (int lost = 0; lost < 12; ++lost) {
    emulator::Hokuyo scanner;
    Hokuyo driver({});
    VirtualLine line(driver, scanner, serial_line(19200));
    int number = 0;
    line.set_lose([&](bool, std::span<const std::byte>) { return number++ == lost; });
    line.start();
    // If the answer to the new rate is lost, the rate is detected at the next start.
    line.run(20s, [&] { return driver.is_ready() || driver.failure(); });
    if (driver.failure()) {
      line.start_host();
      line.run(20s, [&] { return driver.is_ready() || driver.failure(); });
    }
    EXPECT_TRUE(driver.is_ready()) << lost;
  }
}

TEST(HokuyoTest, OneThatMeasuresAlreadyIsStoppedFirst) {
  emulator::Hokuyo scanner({.baud = 115200});
  Hokuyo first({.start = 100, .end = 200, .cluster = 1});
  Hokuyo second({});
  VirtualLine of_first(first, scanner, {});
  of_first.start();
  ASSERT_TRUE(of_first.run(5s, [&] { return first.is_ready(); }));
  // A driver that was killed and restarted.
  VirtualLine of_second(second, scanner, {});
  of_second.start_host();
  LadarData scan;
  Time recorded;
  ASSERT_TRUE(of_second.run(5s, [&] { return second.take(scan, recorded); }));
  EXPECT_EQ(scan.points.size(), 228U);
}

TEST(HokuyoTest, SleepsAtItsOldRateWhenItIsLeft) {
  emulator::Hokuyo scanner;
  Hokuyo driver({});
  VirtualLine line(driver, scanner, serial_line(19200));
  line.start();
  ASSERT_TRUE(line.run(10s, [&] { return driver.is_ready(); }));
  line.stop_host();
  line.run(200ms);
  EXPECT_EQ(scanner.baud(), 19200U);
  EXPECT_FALSE(scanner.measures());
}

TEST(HokuyoTest, ErrorsAreReported) {
  emulator::Hokuyo scanner({.baud = 9600});
  Hokuyo driver({});
  VirtualLine line(driver, scanner, serial_line(9600));
  line.start();
  line.run(20s, [&] { return driver.failure().has_value(); });
  ASSERT_TRUE(driver.failure());
  EXPECT_THAT(driver.failure()->detail(), testing::HasSubstr("neither at 115200 baud"));

  emulator::Hokuyo small;
  Hokuyo wide({.start = 0, .end = 1080});
  VirtualLine to_small(wide, small, {});
  to_small.start();
  to_small.run(20s, [&] { return wide.failure().has_value(); });
  ASSERT_TRUE(wide.failure());
  EXPECT_THAT(wide.failure()->detail(), testing::HasSubstr("between 44 and 725"));
}

TEST(HokuyoTest, ARecordingContainsItsRange) {
  std::vector<std::byte> received;
  {
    emulator::Hokuyo scanner;
    Hokuyo driver({.start = 300, .end = 500, .cluster = 2});
    VirtualLine line(driver, scanner, {});
    line.set_lose([&](bool from_host, std::span<const std::byte> bytes) {
      if (!from_host) received.insert(received.end(), bytes.begin(), bytes.end());
      return false;
    });
    line.start();
    line.run(2s);
  }
  Hokuyo player({.only_listen = true});
  struct Nobody : Output {
    void send(std::span<const std::byte>, std::uint32_t) override { FAIL(); }
  } nobody;
  player.start(Time(1s), nobody);
  LadarData scan;
  Time recorded;
  int scans = 0;
  for (const std::byte& byte : received) {
    player.on_arrival({.bytes = {&byte, 1}, .first = Time(1s), .last = Time(1s)}, nobody);
    scans += player.take(scan, recorded) ? 1 : 0;
  }
  EXPECT_GE(scans, 19);
  EXPECT_EQ(scan.points.size(), 101U);
}

TEST(HokuyoTest, NoiseBreaksNothing) {
  std::mt19937 random(1);
  emulator::Hokuyo scanner;
  Hokuyo driver({});
  VirtualLine line(driver, scanner, serial_line(19200));
  line.start();
  for (int i = 0; i < 500; ++i) {
    std::vector<std::byte> noise(random() % 50);
    for (std::byte& byte : noise) byte = static_cast<std::byte>(random() % 256);
    line.disturb(noise);
    line.run(100ms);
    if (driver.failure()) line.start_host();
  }
  // The scanner measures after the previous measurement was stopped.
  line.run(20s, [&] { return driver.failure().has_value(); });
  if (driver.failure()) line.start_host();
  LadarData scan;
  Time recorded;
  EXPECT_TRUE(line.run(10s, [&] { return driver.take(scan, recorded); }));
}

}  // namespace hokuyo_test
}  // namespace rack::device
