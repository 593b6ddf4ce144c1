#include "components/devices/scanners/rplidar.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/text.h"
#include "components/devices/scanners/rplidar_emulator.h"
#include "rack/devices/virtual_line.h"

namespace rack::device {
namespace rplidar_test {

using namespace std::chrono_literals;
using emulator::VirtualLine;

std::vector<std::byte> bytes(std::string_view hex) { return *tims::base::parse_hex(hex); }

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

// --- Packets

TEST(RplidarPacketsTest, CommandsOfTheManual) {
  std::vector<std::byte> out;
  append_rplidar(out, rplidar::kStop);
  append_rplidar(out, rplidar::kScan);
  append_rplidar(out, rplidar::kExpress, std::array<std::byte, 5>{});
  append_rplidar(out, rplidar::kMotor, bytes("9402"));
  EXPECT_EQ(out, bytes("A525A520A58205000000000022A5F0029402C1"));
  out.clear();
  append_rplidar_answer(out, rplidar::kInfoAnswer, 20, false);
  append_rplidar_answer(out, rplidar::kHealthAnswer, 3, false);
  append_rplidar_answer(out, rplidar::kPoints, 5, true);
  append_rplidar_answer(out, rplidar::kPairs, 84, true);
  append_rplidar_answer(out, rplidar::kTriples, 132, true);
  EXPECT_EQ(out, bytes("A55A1400000004A55A0300000006A55A0500004081A55A5400004082A55A8400004084"));
}

TEST(RplidarPacketsTest, DistancesOfVariableScale) {
  for (std::uint32_t bits = 1; bits < 4096; ++bits) {
    const RplidarScaled before = rplidar_scaled(bits - 1);
    EXPECT_EQ(rplidar_scaled(bits).distance, before.distance + (1 << before.shift)) << bits;
  }
  EXPECT_EQ(rplidar_scaled(511).distance, 511);
  EXPECT_EQ(rplidar_scaled(1280).distance, 2048);
  EXPECT_EQ(rplidar_scaled(4095).distance, 16384 + 767 * 16);
}

// A turn with the points that `decode` adds, and one point before and after them.
template <typename Decode>
LadarData turn_with(Decode decode) {
  TurningScan scan;
  LadarData data;
  Time recorded;
  for (const double angle : {0.0, 100.0, -170.0}) scan.add(radians(angle), 1, 0, Time(1s));
  scan.add(0, 1, 0, Time(1s));
  decode(scan);
  scan.add(radians(100), 1, 0, Time(2s));
  scan.add(radians(-170), 1, 0, Time(2s));
  EXPECT_TRUE(scan.take(data, recorded));
  return data;
}

struct Expected {
  std::size_t point;
  int angle;     // 1/64 degree
  int distance;  // 1/4 mm
};

// Two random packets, and the first one as decoded by the integer arithmetic of public decoders.
void check_packets(std::uint8_t type, const std::string& first, const std::string& second,
                   std::size_t points, std::int64_t quarters, std::vector<Expected> expected) {
  const auto one = bytes(first);
  const auto two = bytes(second);
  const LadarData scan = turn_with([&](TurningScan& into) {
    RplidarPoints decoder;
    decoder.decode({.type = type, .data = one, .began = Time(1s)}, into);
    decoder.decode({.type = type, .data = two, .began = Time(1s + 8ms)}, into);
  });
  ASSERT_EQ(scan.points.size(), points + 3);
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < points; ++i) sum += 4 * std::int64_t{scan.points[i + 2].distance};
  EXPECT_EQ(sum, quarters);
  for (const Expected& point : expected) {
    const LadarPoint& got = scan.points[point.point + 2];
    EXPECT_EQ(got.distance, point.distance / 4) << point.point;
    const double off =
        std::remainder(got.angle - radians(point.angle / 64.0), 2 * std::numbers::pi);
    EXPECT_NEAR(off, 0, radians(1.5 / 64)) << point.point;
  }
}

TEST(RplidarPacketsTest, PairsAsPublicDecodersHaveThem) {
  check_packets(rplidar::kPairs,
                "AC56D05782B70EEE7F1A5039BEF07EC2347F066ED08F5DC7512447E3404300026B6E545594A06568"
                "5D64C4980BB8D4544A8721A99A01AD219EB59CF6A15EF6F15A1D830BB7CE09D6BBC004E7175C643C"
                "7DECB0B5",
                "A954A00080EC37BC9712DD2E6AAEB94BAE8D2F9FA29C5A284C9EF7521829CF1079B080E9D74A1C10"
                "FCAB6A4243D33656DEBE4C1ED79648E856E8F9A2F58C95F0CE4B39C15BFFAD5C2DFB8BB820B6119C"
                "BA8FF887",
                32, 1066596,
                {{0, 22104, 46976},
                 {1, 22190, 60940},
                 {2, 22269, 20504},
                 {15, 22745, 50276},
                 {16, 22376, 47112},
                 {30, 75, 32060},
                 {31, 49, 45292}});
}

TEST(RplidarPacketsTest, TriplesAsPublicDecodersHaveThem) {
  check_packets(rplidar::kTriples,
                "A45D2019B3F4FE05DBE2400C2F00800200D07E0661F43FFA01688106B405FFF987F59F0B8906BF0E"
                "C23203803227BFFB4A68FD01A8D2FD0BCAB5430CA2873E0742014206AA96BD044B694006BBA6FE04"
                "D978820C5404C2F12183FD030E37C105E4027E09E342C107AB0000F8A6A2BC0D22223DFBE71200F7"
                "C5887CFE71073FFDC9D9FC03",
                "AD50401E4523FE07FB453CFC7C767E0C002083F4C1383FF2CC2881FA84917E0233F89F03B0143F0B"
                "11923F8005690102E9F5BFF5820201FD051940F72012C1F39ED5820D03407FF437C5400ED79980F5"
                "3545010D0749BFFEE806FE00A914800713567F0C8B020104282482FAF0477EFE50C0FEFADEA703FA"
                "4A12C0F1F381C10418377EFA",
                96, 1169672,
                {{0, 5963, 7576},
                 {1, 5980, 7440},
                 {2, 6033, 3984},
                 {9, 6075, 0},
                 {10, 6106, 6768},
                 {11, 6116, 7120},
                 {22, 6252, 0},
                 {29, 6348, 0},
                 {94, 7211, 37568},
                 {95, 7289, 4768}});
}

TEST(RplidarPacketsTest, APointOfTheManual) {
  // Quality 62, no start, 89.5 degrees, 1000.75 mm.
  std::vector<std::byte> data = {std::byte{62 << 2 | 2}, std::byte{(5728 << 1 | 1) & 0xFF},
                                 std::byte{(5728 << 1 | 1) >> 8}, std::byte{4003 & 0xFF},
                                 std::byte{4003 >> 8}};
  const LadarData scan = turn_with([&](TurningScan& into) {
    RplidarPoints().decode({.type = rplidar::kPoints, .data = data, .began = Time(1s)}, into);
  });
  ASSERT_EQ(scan.points.size(), 4U);
  EXPECT_NEAR(scan.points[2].angle, radians(89.5), 1e-6);
  EXPECT_EQ(scan.points[2].distance, 1000);
  EXPECT_EQ(scan.points[2].intensity, 62);
}

// The bytes that an emulator sends, from its first measurement on.
std::vector<std::byte> stream_of(std::uint8_t type, Duration how_long = 400ms) {
  std::vector<std::byte> received;
  emulator::Rplidar scanner({.type = type, .spin_up = 10ms});
  Rplidar driver({.only_points = type == rplidar::kPoints});
  VirtualLine line(driver, scanner, {});
  line.start();
  EXPECT_TRUE(line.run(5s, [&] { return driver.is_ready(); }));
  EXPECT_EQ(driver.type(), type);
  append_rplidar_answer(received, type,
                        type == rplidar::kPoints    ? 5
                        : type == rplidar::kTriples ? 132
                                                    : 84,
                        true);
  line.set_lose([&](bool from_host, std::span<const std::byte> sent) {
    if (!from_host) received.insert(received.end(), sent.begin(), sent.end());
    return false;
  });
  line.run(how_long);
  return received;
}

int measurements_in(std::initializer_list<std::span<const std::byte>> pieces) {
  RplidarPackets packets;
  RplidarPacket packet;
  int found = 0;
  for (const auto piece : pieces) {
    packets.add({.bytes = piece});
    while (packets.next(packet)) found += packet.type >= rplidar::kPoints ? 1 : 0;
  }
  return found;
}

constexpr std::array kTypes = {rplidar::kPoints, rplidar::kPairs, rplidar::kTriples,
                               rplidar::kDense};

TEST(RplidarPacketsTest, EverySplitGivesTheSame) {
  for (const std::uint8_t type : kTypes) {
    auto stream = stream_of(type, 100ms);
    stream.resize(std::min<std::size_t>(stream.size(), 800));
    const int all = measurements_in({stream});
    EXPECT_GE(all, 4);
    for (std::size_t cut = 0; cut <= stream.size(); ++cut)
      EXPECT_EQ(measurements_in({std::span(stream).first(cut), std::span(stream).subspan(cut)}),
                all)
          << int{type} << " " << cut;
  }
}

TEST(RplidarPacketsTest, AFlippedBitCostsLittle) {
  for (const std::uint8_t type : kTypes) {
    auto stream = stream_of(type, 100ms);
    stream.resize(std::min<std::size_t>(stream.size(), 1000));
    const int all = measurements_in({stream});
    for (std::size_t bit = 7 * 8; bit < stream.size() * 8 / 2; ++bit) {
      auto broken = stream;
      broken[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
      EXPECT_GE(measurements_in({broken}), all - (type == rplidar::kPoints ? 6 : 1))
          << int{type} << " " << bit;
    }
  }
}

TEST(RplidarPacketsTest, ALostByteCostsLittle) {
  for (const std::uint8_t type : kTypes) {
    const auto stream = stream_of(type);
    const int all = measurements_in({stream});
    for (std::size_t at = 7; at < 700; ++at) {
      auto broken = stream;
      broken.erase(broken.begin() + static_cast<std::ptrdiff_t>(at));
      EXPECT_GE(measurements_in({broken}), all - (type == rplidar::kPoints ? 12 : 1))
          << int{type} << " " << at;
    }
  }
}

// --- The dialogue

TEST(RplidarTest, SeesTheRoomInEachKindOfPackets) {
  for (const std::uint8_t type : kTypes) {
    const emulator::Room room;
    emulator::Rplidar scanner(
        {.baud = 1'000'000, .type = type, .points_a_second = 8000, .sight = room});
    Rplidar driver({.baud = 1'000'000, .only_points = type == rplidar::kPoints});
    VirtualLine line(driver, scanner, {.has_rate = true, .device_baud = 1'000'000});
    line.start();
    LadarData scan;
    Time recorded;
    Time before{};
    int scans = 0;
    while (scans < 5) {
      ASSERT_TRUE(line.run(10s, [&] { return driver.take(scan, recorded); })) << int{type};
      EXPECT_NEAR(static_cast<double>(scan.points.size()), 800, 2);
      EXPECT_NEAR(scan.duration, 100, 2);
      if (scans++ > 0) {
        EXPECT_NEAR(static_cast<double>((recorded - before).count()), 100e6, 2e6);
      }
      before = recorded;
      EXPECT_GT(line.now(), recorded);
      for (const LadarPoint& point : scan.points) {
        EXPECT_EQ(point.type, ladar_point::kUnknown);
        // Tolerances: angles are rounded to 1/64 degree and interpolated within a packet; triples
        // are rounded by up to 8 mm; steep walls amplify these errors.
        EXPECT_NEAR(point.distance, room.distance(point.angle), 25)
            << int{type} << " " << point.angle;
      }
    }
    EXPECT_EQ(driver.type(), type);
    EXPECT_EQ(driver.info().model, 0x18);
    EXPECT_EQ(scan.maxRange, 12'000);
    EXPECT_FALSE(line.dtr());
    line.stop_host();
    line.run(100ms);
    EXPECT_FALSE(scanner.measures());
    EXPECT_TRUE(line.dtr());
  }
}

TEST(RplidarTest, FindsTheRate) {
  for (const std::uint32_t baud : {115200U, 256000U, 460800U, 1'000'000U}) {
    emulator::Rplidar scanner({.baud = baud, .type = rplidar::kDense});
    Rplidar driver({.baud = 460800});
    VirtualLine line(driver, scanner, {.has_rate = true, .host_baud = 9600, .device_baud = baud});
    line.start();
    EXPECT_TRUE(line.run(10s, [&] { return driver.is_ready(); })) << baud;
    EXPECT_EQ(line.host_baud(), baud);
  }
}

TEST(RplidarTest, AnOldOneIsAskedForPoints) {
  emulator::Rplidar scanner({.firmware = 0x010F});
  Rplidar driver({});
  VirtualLine line(driver, scanner, {});
  line.start();
  EXPECT_TRUE(line.run(5s, [&] { return driver.is_ready(); }));
  EXPECT_EQ(driver.type(), rplidar::kPoints);
}

TEST(RplidarTest, TurnsTheMotorOfAnA2) {
  emulator::Rplidar scanner({.model = 0x28});
  Rplidar driver({});
  VirtualLine line(driver, scanner, {});
  line.start();
  EXPECT_TRUE(line.run(5s, [&] { return driver.is_ready(); }));
  EXPECT_EQ(scanner.motor(), 660U);
  line.stop_host();
  line.run(10ms);
  EXPECT_EQ(scanner.motor(), 0U);
}

TEST(RplidarTest, ABrokenScannerIsRestartedOnce) {
  for (const bool stays : {false, true}) {
    emulator::Rplidar scanner({.is_broken = true, .stays_broken = stays});
    Rplidar driver({});
    VirtualLine line(driver, scanner, {});
    line.start();
    line.run(20s, [&] { return driver.is_ready() || driver.failure(); });
    EXPECT_EQ(driver.is_ready(), !stays);
    if (stays) {
      EXPECT_THAT(driver.failure()->detail(), testing::HasSubstr("reports a defect, error 32769"));
    }
  }
}

TEST(RplidarTest, LostAnswersAreAskedForAgain) {
  for (int lost = 0; lost < 12; ++lost) {
    emulator::Rplidar scanner({.type = rplidar::kTriples});
    Rplidar driver({});
    VirtualLine line(driver, scanner, {});
    int number = 0;
    line.set_lose([&](bool, std::span<const std::byte>) { return number++ == lost; });
    line.start();
    line.run(20s, [&] { return driver.is_ready() || driver.failure(); });
    if (driver.failure()) {
      line.start_host();
      line.run(20s, [&] { return driver.is_ready() || driver.failure(); });
    }
    EXPECT_TRUE(driver.is_ready()) << lost;
  }
}

TEST(RplidarTest, AMissingAnswerIsReported) {
  emulator::Rplidar scanner({.baud = 9600});
  Rplidar driver({});
  VirtualLine line(driver, scanner, {.has_rate = true, .host_baud = 9600, .device_baud = 9600});
  line.start();
  line.run(20s, [&] { return driver.failure().has_value(); });
  ASSERT_TRUE(driver.failure());
  EXPECT_THAT(driver.failure()->detail(), testing::HasSubstr("neither at 115200 baud"));
}

TEST(RplidarTest, NoiseBreaksNothing) {
  std::mt19937 random(2);
  emulator::Rplidar scanner({.type = rplidar::kDense});
  Rplidar driver({});
  VirtualLine line(driver, scanner, {});
  line.start();
  for (int i = 0; i < 1000; ++i) {
    std::vector<std::byte> noise(random() % 100);
    for (std::byte& byte : noise)
      byte = static_cast<std::byte>(random() % 4 == 0 ? 0xA5 : random() % 256);
    line.disturb(noise);
    line.run(20ms);
    if (driver.failure()) line.start_host();
  }
  LadarData scan;
  Time recorded;
  EXPECT_TRUE(line.run(10s, [&] { return driver.take(scan, recorded); }));
}

// --- Turns

TEST(TurningScanTest, MorePointsThanFitAreThinnedOut) {
  TurningScan scan;
  LadarData data;
  Time recorded;
  Time now(1s);
  int turns = 0;
  for (int i = 0; i < 5 * 3200; ++i, now += 31us) {
    scan.add(radians(360.0 * i / 3200), 1000, 0, now);
    if (!scan.take(data, recorded)) continue;
    EXPECT_NEAR(static_cast<double>(data.points.size()), 1600, 1);
    ++turns;
    EXPECT_NEAR(data.points.front().angle, -std::numbers::pi, 0.01);
    EXPECT_NEAR(data.points.back().angle, std::numbers::pi, 0.01);
  }
  EXPECT_EQ(turns, 3);  // the first one exceeds the capacity
}

TEST(TurningScanTest, APointThatComesLateEndsNoTurn) {
  TurningScan scan;
  LadarData data;
  Time recorded;
  int turns = 0;
  for (int i = 0; i < 3600; ++i) {
    const double jitter = i % 2 == 0 ? 3 : -3;
    scan.add(radians(i + jitter), 1000, 0, Time(1s + i * 1ms));
    turns += scan.take(data, recorded) ? 1 : 0;
  }
  EXPECT_EQ(turns, 9);
}

TEST(RplidarTest, AnotherScannerIsRefusedByItsNumber) {
  const std::string digits = "c0de0102030405" + std::string(17, '0');
  const auto refusal = [](const std::string& wanted) -> std::string {
    emulator::Rplidar scanner({.serial_number = 7});
    Rplidar driver({.serial_number = wanted});
    VirtualLine line(driver, scanner, {});
    line.start();
    EXPECT_TRUE(line.run(10s, [&] { return driver.is_ready() || driver.failure(); }));
    EXPECT_FALSE(driver.failure() && scanner.measures()) << "it received a command to measure";
    return driver.failure() ? driver.failure()->detail() : "";
  };
  EXPECT_EQ(refusal(digits + "6"),
            "this scanner has serial number " + digits + "7; required: " + digits + "6");
  EXPECT_EQ(refusal(digits + "7"), "");
  EXPECT_EQ(refusal(""), "");
}

}  // namespace rplidar_test
}  // namespace rack::device
