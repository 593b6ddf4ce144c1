#include "components/devices/scan3d/velodyne.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/scan3d/spinning_scanner.h"
#include "rack/devices/virtual_line.h"

namespace rack::device {
namespace velodyne_test {

using namespace std::chrono_literals;
using emulator::VirtualLine;

struct Nobody : Output {
  void send(std::span<const std::byte>, std::uint32_t) override { ADD_FAILURE(); }
};

// The payload of the only datagram of a capture.
std::vector<std::byte> captured() {
  std::ifstream file(DEVICE_DATA "/vlp16.pcap", std::ios::binary);
  const std::string all{std::istreambuf_iterator<char>(file), {}};
  constexpr std::size_t kHeads = 24 + 16 + 42;
  const auto bytes = std::as_bytes(std::span(all)).subspan(kHeads);
  return {bytes.begin(), bytes.end()};
}

TEST(VelodyneTest, ThePacketOfARealScanner) {
  const auto packet = captured();
  ASSERT_EQ(packet.size(), 1212U);
  Velodyne velodyne({.sectors = 360});
  Nobody nobody;
  velodyne.start(Time(1s), nobody);
  velodyne.on_arrival({.bytes = packet, .first = Time(10s), .last = Time(10s)}, nobody);
  EXPECT_TRUE(velodyne.is_ready());
  EXPECT_EQ(velodyne.broken(), 0U);
  // The head turns from 160.27 to 168.22 degrees: sectors 161 to 167 are complete, the newest is
  // kept.
  Scan3dData scan;
  Time recorded;
  ASSERT_TRUE(velodyne.take(scan, recorded));
  EXPECT_EQ(scan.sectorIndex, 167);
  EXPECT_EQ(scan.sectorNum, 360);
  EXPECT_EQ(scan.scanPointNum, 16);
  EXPECT_EQ(scan.scanNum, 3);
  EXPECT_EQ(scan.pointNum, 48);
  EXPECT_LT(recorded, Time(10s));
  EXPECT_GT(recorded, Time(10s) - 2ms);
  // Laser 3 (3 degrees, the tenth from below) at 167.49 degrees: 460 times 2 mm.
  const ScanPoint& point = scan.points[16 + 9];
  const double range = std::hypot(point.x.raw(), point.y.raw(), point.z.raw() - 2.2);
  EXPECT_NEAR(range, 920, 2);
  EXPECT_NEAR(std::atan2(point.y.raw(), point.x.raw()) * 180 / std::numbers::pi, 167.53, 0.1);
  EXPECT_NEAR(point.z.raw(), -920 * std::sin(3 * std::numbers::pi / 180) + 2.2, 1.5);
  EXPECT_EQ(point.intensity, 69);
  EXPECT_EQ(point.type, 0);
}

TEST(VelodyneTest, CutAndFlippedPacketsBreakNothing) {
  const auto packet = captured();
  Velodyne velodyne({.sectors = 36});
  Nobody nobody;
  velodyne.start(Time(1s), nobody);
  for (std::size_t size = 0; size < velodyne::kBytes; ++size)
    velodyne.on_arrival({.bytes = std::span(packet).first(size), .last = Time(2s)}, nobody);
  EXPECT_EQ(velodyne.broken(), velodyne::kBytes);
  for (std::size_t bit = 0; bit < packet.size() * 8; ++bit) {
    auto flipped = packet;
    flipped[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    velodyne.on_arrival({.bytes = flipped, .last = Time(3s)}, nobody);
    if (velodyne.failure()) velodyne.start(Time(3s), nobody);
    Scan3dData scan;
    Time recorded;
    velodyne.take(scan, recorded);
  }
}

TEST(VelodyneTest, AnUnknownModelIsReported) {
  auto packet = captured();
  packet.back() = std::byte{0x99};
  Velodyne velodyne({});
  Nobody nobody;
  velodyne.start(Time(1s), nobody);
  velodyne.on_arrival({.bytes = packet, .last = Time(2s)}, nobody);
  ASSERT_TRUE(velodyne.failure());
  EXPECT_THAT(velodyne.failure()->detail(), testing::HasSubstr("153"));
}

TEST(VelodyneTest, EachModelsBeamsAreDifferent) {
  for (const auto model : {0x21, 0x22, 0x24, 0x28}) {
    const VelodyneLayout* const layout = velodyne_layout(static_cast<std::uint8_t>(model));
    ASSERT_NE(layout, nullptr);
    std::vector<double> elevations;
    for (const VelodyneLaser& laser : layout->lasers) elevations.push_back(laser.elevation);
    std::ranges::sort(elevations);
    EXPECT_EQ(std::ranges::adjacent_find(elevations), elevations.end()) << model;
  }
  EXPECT_NEAR(velodyne_layout(0x21)->lasers[31].elevation, 10.67, 0.01);
}

class VelodyneEmulated : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Sectors, VelodyneEmulated, testing::Values(1, 4));

TEST_P(VelodyneEmulated, TheRoomIsSeenWholeAndInTime) {
  emulator::VelodyneScanner scanner;
  Velodyne driver({.sectors = GetParam(), .range_min = 100});
  VirtualLine line(driver, scanner, {.is_bus = true});
  line.start();
  Scan3dData scan;
  Time recorded;
  int scans = 0;
  const emulator::Room room;
  while (scans < 3 * GetParam()) {
    ASSERT_TRUE(line.run(1s, [&] { return driver.take(scan, recorded); }));
    ++scans;
    EXPECT_NEAR(scan.duration, 100 / GetParam(), 2);
    const double age = std::chrono::duration<double, std::milli>(line.now() - recorded).count();
    EXPECT_NEAR(age, 50.0 / GetParam(), 3);
    EXPECT_NEAR(scan.pointNum, 28930 / GetParam(), 64);
    for (std::size_t i = 0; i < scan.points.size(); i += 37) {
      const ScanPoint& point = scan.points[i];
      ASSERT_EQ(point.type, 0);
      const double level = std::hypot(point.x.raw(), point.y.raw());
      EXPECT_NEAR(level, room.distance(std::atan2(point.y.raw(), point.x.raw())), 30);
    }
  }
  EXPECT_EQ(driver.lost(), 0U);
}

TEST(VelodyneTest, LostDatagramsLeaveGapsOnly) {
  std::mt19937 random(1);
  emulator::VelodyneScanner scanner;
  Velodyne driver({});
  VirtualLine line(driver, scanner, {.is_bus = true});
  line.set_lose([&](bool, std::span<const std::byte>) { return random() % 10 == 0; });
  line.start();
  Scan3dData scan;
  Time recorded;
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(line.run(1s, [&] { return driver.take(scan, recorded); }));
    EXPECT_EQ(scan.pointNum, scan.scanNum * scan.scanPointNum);
    EXPECT_GT(scan.pointNum, 22000);
    EXPECT_LT(scan.pointNum, 28500);
  }
}

TEST(VelodyneTest, SilenceIsReported) {
  Velodyne scanner({});
  Nobody nobody;
  scanner.start(Time(1s), nobody);
  EXPECT_EQ(scanner.next_timeout(), Time(4s));
  scanner.on_timeout(Time(4s), nobody);
  ASSERT_TRUE(scanner.failure());
  EXPECT_THAT(scanner.failure()->detail(), testing::HasSubstr("at this port"));
}

}  // namespace velodyne_test
}  // namespace rack::device
