#include "components/devices/scanners/ibeo.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/text.h"
#include "components/devices/scanners/ibeo_emulator.h"
#include "rack/devices/virtual_line.h"

namespace rack::device {
namespace ibeo_test {

using namespace std::chrono_literals;
using emulator::VirtualLine;

std::string hex(const IbeoFrame& frame) { return tims::base::to_hex(frame); }

TEST(IbeoTest, QuestionsAsTheOriginalSendsThem) {
  std::vector<IbeoFrame> frames;
  append_ibeo(frames, 5, ibeo::kStatus, {});
  append_ibeo(frames, 5, ibeo::kTurn, std::array<std::byte, 2>{});
  append_ibeo(frames, 5, ibeo::kProfiles, *tims::base::parse_hex("000029F0"));
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_EQ(hex(frames[0]), "0000000501020000");
  EXPECT_EQ(hex(frames[1]), "0000000504030000");
  EXPECT_EQ(hex(frames[2]), "ffff000200050301");
  EXPECT_EQ(hex(frames[3]), "0001000029f00000");
  EXPECT_EQ(ibeo::kWanted, 0x29F0U);
}

// Telegrams of any length, with lost frames or frames of other senders in between.
TEST(IbeoTest, TelegramsOfManyFrames) {
  for (std::size_t size = 0; size < 40; ++size) {
    std::vector<std::byte> parameters(size);
    for (std::size_t i = 0; i < size; ++i) parameters[i] = static_cast<std::byte>(i + 1);
    std::vector<IbeoFrame> frames;
    append_ibeo(frames, 1, 0x8301, parameters);
    for (std::size_t lost = 0; lost <= frames.size(); ++lost) {
      IbeoTelegrams telegrams(1);
      IbeoTelegram telegram;
      int whole = 0;
      for (int again = 0; again < 2; ++again)
        for (std::size_t i = 0; i < frames.size(); ++i) {
          if (again == 0 && i == lost) continue;
          if (!telegrams.take({.bytes = frames[i]}, telegram)) continue;
          ++whole;
          ASSERT_GE(telegram.parameters.size(), size);
          EXPECT_TRUE(std::ranges::equal(telegram.parameters.first(size), parameters));
          EXPECT_EQ(telegram.service, 0x8301);
        }
      EXPECT_EQ(whole, lost == frames.size() ? 2 : 1) << size << " " << lost;
    }
  }
  // To a different receiver.
  std::vector<IbeoFrame> frames;
  append_ibeo(frames, 2, 0x8301, std::vector<std::byte>(20));
  append_ibeo(frames, 2, 0x8102, {});
  IbeoTelegrams telegrams(1);
  IbeoTelegram telegram;
  for (const IbeoFrame& frame : frames) EXPECT_FALSE(telegrams.take({.bytes = frame}, telegram));
}

TEST(IbeoTest, AProfileCutAnywhereIsNoMischief) {
  // One sector: step 1 degree, 3 points from 90 degrees; 256 units a metre.
  const auto profile = *tims::base::parse_hex(
      "29F0"
      "0101"
      "0010"
      "0003"
      "0064"
      "05A0"
      "0100"
      "0000"
      "0280"
      "0096"
      "00000003");
  LadarData scan;
  std::uint16_t begin = 0;
  std::uint16_t end = 0;
  IbeoProfile sectors;
  ASSERT_TRUE(sectors.begin(profile));
  ASSERT_TRUE(sectors.next(scan, begin, end));
  EXPECT_EQ(begin, 100);
  EXPECT_EQ(end, 150);
  ASSERT_EQ(scan.points.size(), 3U);
  EXPECT_NEAR(scan.startAngle, -std::numbers::pi / 2, 1e-6);
  EXPECT_NEAR(scan.points[2].angle, -88 * std::numbers::pi / 180, 1e-6);
  EXPECT_EQ(scan.points[0].distance, 1000);
  EXPECT_EQ(scan.points[1].type, ladar_point::kInvalid);
  EXPECT_EQ(scan.points[2].distance, 2500);
  EXPECT_FALSE(sectors.next(scan, begin, end));
  for (std::size_t size = 0; size + 4 < profile.size(); ++size) {
    IbeoProfile cut;
    EXPECT_FALSE(cut.begin(std::span(profile).first(size)) && cut.next(scan, begin, end)) << size;
  }
}

emulator::LineSettings bus() { return {.is_bus = true, .delay = 500us}; }

TEST(IbeoTest, SeesTheRoomInSectors) {
  const emulator::Room room;
  emulator::Ibeo scanner({.sensor = 3, .sight = room});
  Ibeo driver({.sensor = 3});
  VirtualLine line(driver, scanner, bus());
  line.start();
  ASSERT_TRUE(line.run(20s, [&] { return driver.is_ready(); }));
  LadarData scan;
  Time recorded;
  Time before{};
  for (int i = 0; i < 2000; ++i) {  // the clock overflows after 65 s
    ASSERT_TRUE(line.run(1s, [&] { return driver.take(scan, recorded); }));
    const bool is_left = i % 2 == 0;
    ASSERT_EQ(scan.points.size(), 240U);
    ASSERT_NEAR(scan.startAngle, is_left ? -120 * std::numbers::pi / 180 : 0, 1e-5);
    for (const LadarPoint& point : scan.points)
      ASSERT_NEAR(point.distance, room.distance(point.angle), 4);
    if (i > 1) {
      // Time between the middles of two sectors, 33.3 ms, and from one turn to the next, 66.7 ms.
      ASSERT_NEAR(static_cast<double>((recorded - before).count()) / 1e6, is_left ? 66.7 : 33.3,
                  1.2)
          << i;
    }
    before = recorded;
  }
  line.stop_host();
  line.run(1s);
  EXPECT_EQ(scanner.mode(), ibeo::kModeIdle);
  EXPECT_FALSE(scanner.sends());
}

TEST(IbeoTest, LostFramesAreAskedForAgain) {
  for (int lost = 0; lost < 14; ++lost) {
    emulator::Ibeo scanner;
    Ibeo driver({});
    VirtualLine line(driver, scanner, bus());
    int number = 0;
    line.set_lose([&](bool, std::span<const std::byte>) { return number++ == lost; });
    line.start();
    line.run(60s, [&] { return driver.is_ready() || driver.failure(); });
    EXPECT_TRUE(driver.is_ready()) << lost;
  }
}

TEST(IbeoTest, ErrorsAreReported) {
  const auto why = [](const emulator::IbeoSettings& settings, std::uint8_t sensor) {
    emulator::Ibeo scanner(settings);
    Ibeo driver({.sensor = sensor});
    VirtualLine line(driver, scanner, bus());
    line.start();
    line.run(60s, [&] { return driver.failure().has_value(); });
    return driver.failure() ? std::string(driver.failure()->detail()) : "";
  };
  EXPECT_THAT(why({.sensor = 1}, 2), testing::HasSubstr("scanner 2 does not answer"));
  EXPECT_THAT(why({.is_broken = true}, 1), testing::HasSubstr("reports a defect"));
  EXPECT_THAT(why({.measure_error = 3}, 1), testing::HasSubstr("invalid sector borders"));
  EXPECT_THAT(why({.spin_up = 30s}, 1), testing::HasSubstr("within 15 s"));
}

TEST(IbeoTest, NoiseBreaksNothing) {
  std::mt19937 random(4);
  Ibeo driver({});
  struct Nobody : Output {
    void send(std::span<const std::byte>, std::uint32_t) override {}
  } nobody;
  Time now(1s);
  driver.start(now, nobody);
  LadarData scan;
  Time recorded;
  for (int i = 0; i < 100'000; ++i) {
    IbeoFrame frame;
    for (std::byte& byte : frame) byte = static_cast<std::byte>(random() % 3 == 0 ? random() : 0);
    if (random() % 4 == 0) frame[0] = frame[1] = std::byte{0xFF};
    if (random() % 2 == 0) frame[6] = std::byte{0x83};
    frame[5] = frame[3] = std::byte{1};
    now += 1ms;
    driver.on_arrival({.bytes = std::span(frame).first(random() % 8 == 0 ? random() % 8 : 8),
                       .first = now,
                       .last = now,
                       .id = 0x701},
                      nobody);
    driver.take(scan, recorded);
    driver.on_timeout(now, nobody);
    if (driver.failure()) driver.start(now, nobody);
  }
}

}  // namespace ibeo_test
}  // namespace rack::device
