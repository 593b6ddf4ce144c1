#include "components/devices/scanners/sick_s.h"

#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/scanners/sick_s_emulator.h"
#include "rack/devices/virtual_line.h"

namespace rack::device {
namespace sick_s_test {

using namespace std::chrono_literals;
using emulator::SickSEmulator;
using emulator::SickSEmulatorSettings;
using emulator::VirtualLine;

constexpr double kDegree = std::numbers::pi / 180;

std::vector<std::byte> bytes_of(std::initializer_list<int> values) {
  std::vector<std::byte> bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

std::vector<std::byte> blocks_of(SickSDevice device) {
  std::vector<std::byte> blocks;
  emulator::append_sick_s_scan(blocks, device, emulator::Room{}, {});
  return blocks;
}

std::vector<std::byte> telegram_of(SickSDevice device, std::uint32_t number = 1) {
  const auto blocks = blocks_of(device);
  std::vector<std::byte> out;
  append_sick_s(out, {.address = 7, .scan_number = number, .blocks = blocks});
  return out;
}

std::size_t count(SickSTelegrams& telegrams) {
  std::size_t found = 0;
  for (SickSTelegram telegram; telegrams.next(telegram);) ++found;
  return found;
}

TEST(SickSTest, TheCrcIsCcitt) {
  constexpr std::string_view kCheck = "123456789";
  EXPECT_EQ(sick_s_crc(std::as_bytes(std::span(kCheck))), 0x29B1);
}

TEST(SickSTest, ATelegramIsAsItIsDescribed) {
  const auto s300 = telegram_of(SickSDevice::kS300);
  ASSERT_EQ(s300.size(), 1108U);
  EXPECT_EQ(big_endian<std::uint16_t>(s300, 6), 552);  // 541 values + 11 other units
  EXPECT_EQ(std::vector(s300.begin() + 20, s300.begin() + 24), bytes_of({0xBB, 0xBB, 0x11, 0x11}));
  EXPECT_EQ(telegram_of(SickSDevice::kS3000).size(), 788U);
}

TEST(SickSTest, AScanGoesClockwise) {
  SickSTelegrams telegrams;
  const auto bytes = telegram_of(SickSDevice::kS300, 42);
  telegrams.add({.bytes = bytes});
  SickSTelegram telegram;
  ASSERT_TRUE(telegrams.next(telegram));
  EXPECT_EQ(telegram.scan_number, 42U);
  EXPECT_EQ(telegram.address, 7);
  LadarData scan;
  ASSERT_TRUE(decode_sick_s_scan(telegram, SickSDevice::kS300, scan));
  ASSERT_EQ(scan.points.size(), 541U);
  EXPECT_NEAR(scan.startAngle, -135 * kDegree, 1e-6);
  EXPECT_NEAR(scan.endAngle, 135 * kDegree, 1e-6);
  EXPECT_EQ(scan.duration, 40U);
  EXPECT_EQ(scan.maxRange, 30000);
  const emulator::Room room;
  for (const LadarPoint& point : scan.points)
    EXPECT_NEAR(point.distance, room.distance(point.angle), 6);
  EXPECT_FALSE(decode_sick_s_scan(telegram, SickSDevice::kS3000, scan));
}

TEST(SickSTest, FlagsAndCodes) {
  auto blocks = blocks_of(SickSDevice::kS3000);
  const auto put = [&](std::size_t value, unsigned number) {
    blocks[4 + 2 * value] = static_cast<std::byte>(number);
    blocks[5 + 2 * value] = static_cast<std::byte>(number >> 8);
  };
  put(0, 0x2000 | 250);  // a reflector
  put(1, 0xC000 | 251);  // within the protective and the warning field
  put(2, 0x1FFF);
  put(3, 0);
  LadarData scan;
  ASSERT_TRUE(decode_sick_s_scan({.address = 7, .blocks = blocks}, SickSDevice::kS3000, scan));
  EXPECT_EQ(scan.points[380].distance, 2500);
  EXPECT_EQ(scan.points[380].type, ladar_point::kReflector);
  EXPECT_EQ(scan.points[379].distance, 2510);
  EXPECT_EQ(scan.points[379].type, ladar_point::kUnknown);
  EXPECT_EQ(scan.points[378].type, ladar_point::kInvalid);
  EXPECT_EQ(scan.points[377].type, ladar_point::kInvalid);
  EXPECT_NEAR(scan.endAngle, 95 * kDegree, 1e-6);
}

// The size in newer versions is smaller by two units.
TEST(SickSTest, BothDefinitionsOfTheSize) {
  auto newer = telegram_of(SickSDevice::kS300);
  newer[7] = static_cast<std::byte>(std::to_integer<int>(newer[7]) - 2);
  const std::uint16_t crc = sick_s_crc(std::span(newer).subspan(4, newer.size() - 6));
  newer[newer.size() - 2] = static_cast<std::byte>(crc);
  newer[newer.size() - 1] = static_cast<std::byte>(crc >> 8);
  SickSTelegrams telegrams;
  telegrams.add({.bytes = newer});
  SickSTelegram telegram;
  ASSERT_TRUE(telegrams.next(telegram));
  LadarData scan;
  EXPECT_TRUE(decode_sick_s_scan(telegram, SickSDevice::kS300, scan));
}

TEST(SickSTest, EverySplitGivesTheSameTelegrams) {
  std::vector<std::byte> stream = bytes_of({0, 0, 0, 5, 0, 0, 0, 0, 0, 0, 0, 9, 0xFF});
  for (std::uint32_t i = 0; i < 3; ++i) {
    const auto one = telegram_of(SickSDevice::kS3000, i);
    stream.insert(stream.end(), one.begin(), one.end());
  }
  for (std::size_t cut = 0; cut <= stream.size(); ++cut) {
    SickSTelegrams telegrams;
    telegrams.add({.bytes = std::span(stream).first(cut)});
    std::size_t found = count(telegrams);
    telegrams.add({.bytes = std::span(stream).subspan(cut)});
    found += count(telegrams);
    EXPECT_EQ(found, 3U) << cut;
  }
}

TEST(SickSTest, AFlippedBitCostsOneTelegram) {
  const auto one = telegram_of(SickSDevice::kS3000);
  for (std::size_t i = 0; i < one.size() * 8; ++i) {
    auto stream = one;
    stream[i / 8] ^= static_cast<std::byte>(1 << i % 8);
    for (int again = 0; again < 6; ++again) stream.insert(stream.end(), one.begin(), one.end());
    SickSTelegrams telegrams;
    telegrams.add({.bytes = stream});
    const std::size_t found = count(telegrams);
    EXPECT_GE(found, 6U) << i;
    EXPECT_LE(found, 6U) << i;
  }
}

TEST(SickSTest, TakesTheScansOfItsDevice) {
  for (const bool is_slave : {false, true}) {
    SickS host({.device = SickSDevice::kS300, .is_slave = is_slave});
    SickSEmulator scanner({.is_slave = is_slave, .sends_inputs = true});
    VirtualLine line(host, scanner,
                     {.has_rate = true, .host_baud = 500000, .device_baud = 500000, .piece = 64});
    line.start();
    ASSERT_TRUE(line.run(1s, [&] { return host.is_ready(); }));
    std::size_t taken = 0;
    Time last{};
    EXPECT_FALSE(line.run(10s, [&] {
      LadarData scan;
      Time recorded;
      if (host.take(scan, recorded)) {
        EXPECT_TRUE(taken++ < 2 || std::chrono::abs(recorded - last - 40ms) < 100us);
        last = recorded;
      }
      return false;
    }));
    EXPECT_NEAR(static_cast<double>(taken), 250, 1);
  }
}

std::string complaint(const SickSSettings& settings, const SickSEmulatorSettings& scanner_settings,
                      bool is_there = true) {
  SickS host(settings);
  SickSEmulator scanner(scanner_settings);
  VirtualLine line(
      host, scanner,
      {.has_rate = true, .host_baud = settings.baud, .device_baud = scanner_settings.baud});
  line.set_lose([&](bool, std::span<const std::byte>) { return !is_there; });
  line.start();
  line.run(5s, [&] { return host.is_ready() || host.failure(); });
  return host.failure() ? host.failure()->detail() : "";
}

TEST(SickSTest, TheReasonForNoScanIsReported) {
  using testing::HasSubstr;
  EXPECT_EQ(complaint({}, {}), "");
  EXPECT_THAT(complaint({}, {}, false), HasSubstr("sends nothing"));
  EXPECT_THAT(complaint({}, {.is_slave = true}), HasSubstr("set EFIdev=1"));
  EXPECT_THAT(complaint({.is_slave = true}, {}), HasSubstr("set EFIdev=0"));
  EXPECT_THAT(complaint({.device = SickSDevice::kS3000}, {}), HasSubstr("devNumber"));
  EXPECT_THAT(complaint({}, {.baud = 38400}), HasSubstr("rate is 500000 baud"));
}

TEST(SickSTest, NoiseBreaksNothing) {
  std::mt19937 random(1);
  SickS host({});
  SickSEmulator scanner;
  VirtualLine line(host, scanner, {.has_rate = true, .host_baud = 500000, .device_baud = 500000});
  line.start();
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::byte> noise(random() % 100);
    for (std::byte& byte : noise) byte = static_cast<std::byte>(random() % 2 == 0 ? 0 : random());
    line.disturb(noise);
    line.run(10ms);
    if (host.failure()) line.start_host();
  }
  line.run(1s);
  EXPECT_TRUE(host.is_ready());
}

}  // namespace sick_s_test
}  // namespace rack::device
