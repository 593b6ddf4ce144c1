#include "components/devices/scanners/ld19.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/text.h"
#include "components/devices/scanners/ld19_emulator.h"
#include "rack/devices/virtual_line.h"

namespace rack::device {
namespace ld19_test {

using namespace std::chrono_literals;
using emulator::VirtualLine;

// Example in the development manual.
constexpr std::string_view kPacket =
    "542C6808AB7EE000E4DC00E2D900E5D500E3D300E4D000E9CD00E4CA00E2C700E9C500E5C200E5C000E5BE823A1A5"
    "0";

struct Nobody : Output {
  void send(std::span<const std::byte>, std::uint32_t) override { FAIL(); }
};

TEST(Ld19Test, ThePacketOfTheManual) {
  const auto packet = *tims::base::parse_hex(kPacket);
  ASSERT_EQ(packet.size(), kLd19Size);
  EXPECT_EQ(ld19_crc(std::span(packet).first(46)), 0x50);
  Nobody nobody;
  Ld19 driver({.only_listen = true});
  driver.start(Time(1s), nobody);
  driver.on_arrival({.bytes = packet, .first = Time(1s), .last = Time(1s)}, nobody);
  EXPECT_EQ(driver.packets(), 1U);
  EXPECT_FALSE(driver.is_ready());
}

TEST(Ld19Test, EverySplitAndEveryFlippedBit) {
  const auto packet = *tims::base::parse_hex(kPacket);
  std::vector<std::byte> stream;
  for (int i = 0; i < 3; ++i) stream.insert(stream.end(), packet.begin(), packet.end());
  Nobody nobody;
  const auto packets_in = [&](std::span<const std::byte> bytes, std::size_t cut) {
    Ld19 driver({.only_listen = true});
    driver.start(Time(1s), nobody);
    driver.on_arrival({.bytes = bytes.first(cut)}, nobody);
    driver.on_arrival({.bytes = bytes.subspan(cut)}, nobody);
    return driver.packets();
  };
  for (std::size_t cut = 0; cut <= stream.size(); ++cut) EXPECT_EQ(packets_in(stream, cut), 3U);
  for (std::size_t i = 0; i < packet.size() * 8; ++i) {
    auto broken = stream;
    broken[i / 8] ^= static_cast<std::byte>(1 << i % 8);
    EXPECT_EQ(packets_in(broken, 0), 2U) << i;
  }
  for (std::size_t from = 1; from < packet.size(); ++from)
    EXPECT_EQ(packets_in(std::span(stream).subspan(from), 0), 2U);
}

TEST(Ld19Test, SeesTheRoom) {
  const emulator::Room room;
  emulator::Ld19 scanner({.sight = room});
  Ld19 driver({});
  VirtualLine line(driver, scanner, {.has_rate = true, .piece = 16});
  line.start();
  EXPECT_EQ(line.host_baud(), 230400U);
  LadarData scan;
  Time recorded;
  Time before{};
  for (int i = 0; i < 400; ++i) {  // the time wraps after 30 s
    ASSERT_TRUE(line.run(1s, [&] { return driver.take(scan, recorded); }));
    EXPECT_NEAR(static_cast<double>(scan.points.size()), 450, 1);
    EXPECT_NEAR(scan.duration, 100, 1);
    if (i > 20) {
      EXPECT_NEAR(static_cast<double>((recorded - before).count()), 100e6, 2e6) << i;
    }
    before = recorded;
    // Its last points were measured just now.
    EXPECT_NEAR(static_cast<double>((line.now() - recorded).count()), 52e6, 6e6) << i;
    for (const LadarPoint& point : scan.points) {
      ASSERT_NEAR(point.distance, room.distance(point.angle), 5) << point.angle;
      ASSERT_EQ(point.intensity, 200);
    }
  }
}

TEST(Ld19Test, AMissingScanIsReported) {
  Nobody nobody;
  Ld19 driver({});
  driver.start(Time(1s), nobody);
  std::mt19937 random(1);
  std::vector<std::byte> noise(10'000);
  for (std::byte& byte : noise) byte = static_cast<std::byte>(random() % 256);
  driver.on_arrival({.bytes = noise, .first = Time(1s), .last = Time(1s)}, nobody);
  EXPECT_FALSE(driver.is_ready());
  ASSERT_EQ(driver.next_timeout(), Time(6s));
  driver.on_timeout(Time(6s), nobody);
  ASSERT_TRUE(driver.failure());
  EXPECT_THAT(driver.failure()->detail(), testing::HasSubstr("230400"));
}

}  // namespace ld19_test
}  // namespace rack::device
