#include "components/devices/scanners/sick_compact.h"

#include <numbers>
#include <random>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/scanners/sick_compact_emulator.h"
#include "rack/devices/stream_buffer.h"
#include "rack/devices/virtual_line.h"

namespace rack::device {
namespace sick_compact_test {

using namespace std::chrono_literals;
using emulator::SickCompactEmulator;
using emulator::SickCompactEmulatorSettings;
using emulator::VirtualLine;

constexpr double kDegree = std::numbers::pi / 180;

std::vector<std::byte> segment_of(const SickCompactEmulatorSettings& settings, std::uint64_t frame,
                                  int number) {
  std::vector<std::byte> datagram;
  append_compact(datagram, settings, frame, number, 1000000, 1050000);
  return datagram;
}

TEST(SickCompactTest, TheCrcIsTheUsualOne) {
  const auto crc_of = [](std::string_view text) { return crc32(std::as_bytes(std::span(text))); };
  EXPECT_EQ(crc_of(""), 0U);
  EXPECT_EQ(crc_of("123456789"), 0xCBF43926U);
  EXPECT_EQ(crc_of("The quick brown fox jumps over the lazy dog"), 0x414FA339U);
}

TEST(SickCompactTest, ASegmentOfBothVersions) {
  for (const std::uint32_t version : {3U, 4U}) {
    const SickCompactEmulatorSettings settings{.version = version};
    const auto datagram = segment_of(settings, 7, 3);
    // 32 bytes, 36 of the module's head, 28 of its layer, a factor, 8 more, beams of 7, the CRC.
    EXPECT_EQ(datagram.size(), 32U + 36 + 28 + (version == 4 ? 4 : 0) + 8 - 4 + 276 * 7 + 4);
    CompactSegment segment;
    ASSERT_EQ(decode_compact(datagram, segment), CompactKind::kSegment);
    EXPECT_EQ(segment.counter, 7U * 12 + 3 + 1);
    EXPECT_EQ(segment.frame_number, 7U);
    EXPECT_EQ(segment.serial_number, 23110001U);
    EXPECT_EQ(segment.transmitted, 1050000U);
    EXPECT_EQ(segment.started, 1012498U);
    ASSERT_EQ(segment.beams.size(), 276U);
    EXPECT_NEAR(segment.beams[0].azimuth, (-138 + 69) * kDegree, 2e-4);
    EXPECT_NEAR(segment.beams[275].azimuth, (-138 + 92 - 1.0 / 12) * kDegree, 2e-4);
    const emulator::Room room;
    for (const CompactBeam& beam : segment.beams)
      EXPECT_NEAR(beam.distance, room.distance(-static_cast<double>(beam.azimuth)), 3);
    EXPECT_EQ(segment.beams[0].remission, 1000);
    EXPECT_FALSE(segment.beams[0].is_reflector);
  }
}

TEST(SickCompactTest, TheMostLevelLayerAndTheFirstEcho) {
  const SickCompactEmulatorSettings settings{
      .elevations = {0.4F, -0.2F, 0.002F, 0.2F}, .echoes = 3, .factor = 2};
  CompactSegment segment;
  ASSERT_EQ(decode_compact(segment_of(settings, 1, 0), segment), CompactKind::kSegment);
  EXPECT_EQ(segment.elevation, 0.002F);
  const emulator::Room room;
  for (const CompactBeam& beam : segment.beams)
    EXPECT_NEAR(beam.distance, room.distance(-static_cast<double>(beam.azimuth)), 5);
}

// The sample of SICK's ScanSegmentAPI, whose values are documented: two modules with one layer and
// two echoes each, with azimuths and without flags, in version 3.
TEST(SickCompactTest, ASampleThatIsDescribed) {
  std::vector<std::byte> out;
  const auto put = [&](std::uint64_t number, std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; ++i) out.push_back(static_cast<std::byte>(number >> 8 * i));
  };
  const auto put_float = [&](double number) {
    put(std::bit_cast<std::uint32_t>(static_cast<float>(number)), 4);
  };
  constexpr std::size_t kBeam = 2 * 4 + 2;
  constexpr std::size_t kModule = 36 + 28 + 8 + 10 * kBeam - 4;
  put(0x02020202, 4);
  put(1, 4);
  put(333, 8);
  put(444, 8);
  put(3, 4);
  put(kModule, 4);
  for (const bool is_first : {true, false}) {
    put(666, 8);
    put(999, 8);
    put(555, 4);
    put(1, 4);
    put(10, 4);
    put(2, 4);
    put(100, 8);
    put(200, 8);
    put_float(is_first ? 0 : 0.1);
    put_float((is_first ? 0 : 90) * kDegree);
    put_float((is_first ? 9 : 99) * kDegree);
    put(is_first ? kModule : 0, 4);
    put(1, 1);
    put(3, 1);
    put(2, 1);
    put(0, 1);
    for (int beam = 0; beam < 10; ++beam) {
      for (int echo = 0; echo < 2; ++echo) {
        put(is_first ? 123 : 456, 2);
        put(is_first ? 21036 : 44432, 2);
      }
      const double azimuth = ((is_first ? 0 : 90) + beam) * kDegree;
      put(static_cast<std::uint64_t>(std::lround(azimuth * 5215) + 16384), 2);
    }
  }
  put(crc32(out), 4);

  CompactSegment segment;
  ASSERT_EQ(decode_compact(out, segment), CompactKind::kSegment);
  EXPECT_EQ(segment.counter, 333U);
  EXPECT_EQ(segment.transmitted, 444U);
  EXPECT_EQ(segment.frame_number, 999U);
  EXPECT_EQ(segment.serial_number, 555U);
  ASSERT_EQ(segment.beams.size(), 10U);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(segment.beams[i].distance, 123U);
    EXPECT_EQ(segment.beams[i].remission, 21036);
    EXPECT_NEAR(segment.beams[i].azimuth, static_cast<double>(i) * kDegree, 1e-3);
  }
}

TEST(SickCompactTest, WhatIsBrokenIsNothing) {
  const SickCompactEmulatorSettings settings{.beams = 20, .elevations = {0, 0.1F}};
  const auto datagram = segment_of(settings, 1, 1);
  CompactSegment segment;
  for (std::size_t size = 0; size < datagram.size(); ++size)
    EXPECT_EQ(decode_compact(std::span(datagram).first(size), segment), CompactKind::kBroken);
  for (std::size_t i = 0; i < datagram.size() * 8; ++i) {
    auto flipped = datagram;
    flipped[i / 8] ^= static_cast<std::byte>(1 << i % 8);
    EXPECT_EQ(decode_compact(flipped, segment), CompactKind::kBroken) << i;
    // The same with a corrected CRC.
    const std::size_t end = flipped.size() - 4;
    const std::uint32_t crc = crc32(std::span(flipped).first(end));
    for (std::size_t j = 0; j < 4; ++j) flipped[end + j] = static_cast<std::byte>(crc >> 8 * j);
    (void)decode_compact(flipped, segment);
  }
}

struct Pair {
  explicit Pair(const SickCompactSettings& settings = {},
                const SickCompactEmulatorSettings& scanner_settings = {})
      : host(settings), scanner(scanner_settings), line(host, scanner, {.is_bus = true}) {}

  // Takes scans for a time; determines the maximum deviation from the room, mm.
  std::size_t take_for(Duration how_long) {
    std::size_t taken = 0;
    line.run(how_long, [&] {
      taken += host.take(scan, recorded) ? 1U : 0U;
      return host.failure().has_value();
    });
    return taken;
  }

  SickCompact host;
  SickCompactEmulator scanner;
  VirtualLine line;
  LadarData scan;
  Time recorded;
};

TEST(SickCompactTest, PutsATurnTogether) {
  Pair pair;
  pair.line.start();
  EXPECT_FALSE(pair.host.is_ready());
  const std::size_t taken = pair.take_for(10s);
  EXPECT_TRUE(pair.host.is_ready());
  EXPECT_NEAR(static_cast<double>(taken), 198, 1);
  // 3312 beams exceed the capacity of a scan: every second one is kept.
  ASSERT_EQ(pair.scan.points.size(), 1656U);
  EXPECT_NEAR(pair.scan.startAngle, -138 * kDegree, 2e-3);
  EXPECT_NEAR(pair.scan.endAngle, 138 * kDegree, 2e-3);
  EXPECT_EQ(pair.scan.duration, 50U);
  const emulator::Room room;
  for (std::size_t i = 0; i < pair.scan.points.size(); ++i) {
    const LadarPoint& point = pair.scan.points[i];
    EXPECT_NEAR(point.distance, room.distance(point.angle), 3);
    ASSERT_TRUE(i == 0 || point.angle > pair.scan.points[i - 1].angle) << i;
  }
  // The last turn ended when its last segment was sent; its middle was 25 ms before.
  const Duration age = (pair.line.now() - pair.recorded) % 50ms;
  EXPECT_NEAR(static_cast<double>(age.count()), 25e6, 2e5);
}

TEST(SickCompactTest, ATurnIsSentWithItsLastSegment) {
  Pair pair({}, {.segments = 4});
  pair.line.start();
  pair.take_for(1s);
  // Some waits give two turns; each is available at its end.
  std::set<Duration> ages;
  pair.line.run(1s, [&] {
    if (pair.host.take(pair.scan, pair.recorded)) ages.insert(pair.line.now() - pair.recorded);
    return false;
  });
  ASSERT_FALSE(ages.empty());
  EXPECT_LT(*ages.rbegin(), 25ms + 100us);
}

TEST(SickCompactTest, LostSegmentsLeaveAGap) {
  Pair pair;
  std::mt19937 random(1);
  pair.line.set_lose([&](bool, std::span<const std::byte>) { return random() % 50 == 0; });
  pair.line.start();
  std::size_t whole = 0;
  std::size_t taken = 0;
  pair.line.run(20s, [&] {
    if (!pair.host.take(pair.scan, pair.recorded)) return false;
    ++taken;
    whole += pair.scan.points.size() == 1656 ? 1U : 0U;
    EXPECT_GT(pair.scan.points.size(), 1000U);
    return false;
  });
  EXPECT_GT(taken, 380U);
  EXPECT_GT(whole, 250U);
}

TEST(SickCompactTest, FewerSegmentsThanBeforeAreNoticed) {
  SickCompact host({});
  struct Discard : Output {
    void send(std::span<const std::byte>, std::uint32_t) override {}
  } discard;
  host.start({}, discard);
  Time now{1000s};
  LadarData scan;
  Time recorded;
  const auto turn = [&](std::uint64_t frame, int segments) {
    bool at_end = false;
    for (int i = 0; i < segments; ++i) {
      now += 1ms;
      const auto datagram = segment_of({.segments = segments, .beams = 10}, frame, i);
      host.on_arrival({.bytes = datagram, .first = now, .last = now}, discard);
      at_end = host.take(scan, recorded) && i + 1 == segments;
    }
    return at_end;
  };
  for (std::uint64_t frame = 0; frame < 5; ++frame) turn(frame, 12);
  EXPECT_TRUE(turn(5, 12));
  EXPECT_FALSE(turn(6, 6));
  for (std::uint64_t frame = 7; frame < 40; ++frame) turn(frame, 6);
  EXPECT_TRUE(turn(40, 6));
  EXPECT_FALSE(turn(41, 8));
  turn(42, 8);
  EXPECT_TRUE(turn(43, 8));
  // A datagram that arrives out of order.
  const auto late = segment_of({.segments = 8, .beams = 10}, 42, 1);
  host.on_arrival({.bytes = late, .first = now, .last = now}, discard);
  EXPECT_TRUE(turn(44, 8));
}

TEST(SickCompactTest, TheReasonForNoScanIsReported) {
  using testing::HasSubstr;
  Pair nobody;
  nobody.line.set_lose([](bool, std::span<const std::byte>) { return true; });
  nobody.line.start();
  nobody.take_for(10s);
  ASSERT_TRUE(nobody.host.failure());
  EXPECT_THAT(nobody.host.failure()->detail(), HasSubstr("no datagrams received"));

  Pair another({.serial_number = 5}, {.serial_number = 6});
  another.line.start();
  another.take_for(10s);
  ASSERT_TRUE(another.host.failure());
  EXPECT_THAT(another.host.failure()->detail(), HasSubstr("serial number 6"));

  Pair other;
  other.line.set_lose([](bool, std::span<const std::byte>) { return true; });
  other.line.start();
  other.line.disturb(std::vector<std::byte>(100, std::byte{2}));
  other.take_for(10s);
  ASSERT_TRUE(other.host.failure());
  EXPECT_THAT(other.host.failure()->detail(), HasSubstr("MSGPACK"));
}

}  // namespace sick_compact_test
}  // namespace rack::device
