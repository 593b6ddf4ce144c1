#include "rack/proxies/scan3d_compression.h"

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/counted_new.h"

namespace rack {
namespace scan3d_compression_test {

using testing::HasSubstr;

bool same(const ScanPoint& a, const ScanPoint& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z && a.type == b.type && a.segment == b.segment &&
         a.intensity == b.intensity;
}

Scan3dData scan_of(std::vector<ScanPoint> points) {
  Scan3dData scan{.pointNum = static_cast<i32>(points.size())};
  scan.points.assign(points.begin(), points.end());
  return scan;
}

// A room of 6 x 8 x 3 m, seen from its middle, with noise and glass.
Scan3dData room(std::size_t lines, std::size_t line_points, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 8);
  std::vector<ScanPoint> points;
  for (std::size_t i = 0; i < lines * line_points; ++i) {
    const std::size_t line = i / line_points;
    const double across = std::numbers::pi * static_cast<double>(line) / static_cast<double>(lines);
    const double up = 2 * std::numbers::pi * static_cast<double>(i % line_points) /
                      static_cast<double>(line_points);
    const double x = std::cos(up) * std::cos(across);
    const double y = std::cos(up) * std::sin(across);
    const double z = std::sin(up);
    const double range = std::min({3000 / std::abs(x), 4000 / std::abs(y), 1500 / std::abs(z)});
    const double seen = range + noise(random);
    if (i / 40 % 25 == 3)
      points.push_back({.type = scan_point::kInvalid | scan_point::kMaxRange});
    else
      points.push_back({.x = static_cast<i32>(x * seen),
                        .y = static_cast<i32>(y * seen),
                        .z = static_cast<i32>(z * seen),
                        .type = i % 500 == 0 ? scan_point::kReflector : 0,
                        .intensity = static_cast<i16>(i % 200)});
  }
  return scan_of(std::move(points));
}

void expect_back(const Scan3dData& scan) {
  Scan3dCompression compression;
  Scan3dData there = scan;
  if (!compression.compress(there)) {
    EXPECT_EQ(there.compressed, 0);
    EXPECT_EQ(there.points.size(), scan.points.size());
    return;
  }
  EXPECT_TRUE(there.points.empty());
  ASSERT_EQ(static_cast<std::size_t>(there.compressed), there.compressedPoints.size());
  EXPECT_LE(there.compressedPoints.size(), scan.points.size() * 20);
  const auto back = compression.decompress(there);
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(there.compressed, 0);
  EXPECT_TRUE(there.compressedPoints.empty());
  EXPECT_TRUE(std::ranges::equal(there.points, scan.points, same));
}

TEST(Scan3dCompression, LosesNothing) {
  const Scan3dData scan = room(100, 181);
  expect_back(scan);
  Scan3dData small = scan;
  Scan3dCompression compression;
  ASSERT_TRUE(compression.compress(small));
  EXPECT_LT(small.compressed * 3, static_cast<i32>(scan.points.size()) * 20);
}

TEST(Scan3dCompression, LosesNothingOfExtremes) {
  constexpr i32 kMax = std::numeric_limits<i32>::max();
  constexpr i32 kMin = std::numeric_limits<i32>::min();
  const std::vector<ScanPoint> extremes = {
      {.x = kMin, .y = kMax, .z = -1, .type = kMin, .segment = -32768, .intensity = 32767},
      {.x = kMax, .y = kMin, .z = 0, .type = kMax, .segment = 32767, .intensity = -32768},
      {},
  };
  for (const std::size_t count : {1U, 2U, 3U, 50U, 255U, 256U, 257U, 511U, 5000U}) {
    std::vector<ScanPoint> points(count, ScanPoint{.x = 7, .type = 0x10, .segment = 300});
    expect_back(scan_of(points));
    points.back() = extremes[count % 3];
    points[count / 2] = extremes[(count + 1) % 3];
    expect_back(scan_of(points));
  }
  for (unsigned seed = 0; seed < 300;
       ++seed) {  // differences around the largest that fits into one byte
    std::mt19937 random(seed);
    std::vector<ScanPoint> points(1 + random() % 600);
    i32 last = 0;
    for (ScanPoint& point : points) {
      last += static_cast<i32>(random() % 400) - 200;
      point = {.x = last, .y = -last, .type = static_cast<i32>(random() % 3 / 2 * 0x10)};
      point.segment = static_cast<i16>(seed % 4 == 0 ? -1 : 0);
      point.intensity = static_cast<i16>(seed % 3 == 0 ? 77 : seed % 3 * random());
    }
    expect_back(scan_of(points));
  }
}

// A scan of noise would become larger: it remains uncompressed.
TEST(Scan3dCompression, LeavesWhatWouldNotBecomeSmaller) {
  std::mt19937 random(3);
  std::vector<ScanPoint> points(300);
  for (ScanPoint& point : points)
    point = {.x = static_cast<i32>(random()),
             .y = static_cast<i32>(random()),
             .z = static_cast<i32>(random()),
             .type = static_cast<i32>(random()),
             .segment = static_cast<i16>(random()),
             .intensity = static_cast<i16>(random())};
  Scan3dData scan = scan_of(points);
  Scan3dCompression compression;
  EXPECT_FALSE(compression.compress(scan));
  EXPECT_EQ(scan.points.size(), 300U);
  EXPECT_TRUE(scan.compressedPoints.empty());
  Scan3dData none;
  EXPECT_FALSE(compression.compress(none));
}

std::vector<std::byte> bytes(std::initializer_list<int> values) {
  std::vector<std::byte> all;
  for (const int value : values) all.push_back(static_cast<std::byte>(value));
  return all;
}

Scan3dData compressed(std::vector<std::byte> data, i32 points) {
  Scan3dData scan{.pointNum = points, .compressed = static_cast<i32>(data.size())};
  scan.compressedPoints.assign(data.begin(), data.end());
  return scan;
}

// Written by hand from the specification: stage 1 alone, method 5.
TEST(Scan3dCompression, ReadsTheFormatOfTheSpecification) {
  auto scan = compressed(
      bytes({0x4D, 0x31, 0,    0,    0,    5,    0,    0,    0, 60, 0, 0, 0, 55,  // head
             0xFF, 0xFF, 0xFF, 0x9C,                                              // -x: 100
             0,    0,    0,    5,                                                 // y: -5
             0,    0,    0,    0,                                                 // z
             0,    0,    0,    0,    0,    0,    0xFF, 0xF8,  // type, segment, intensity: 8
             0x48, 0x11,                                      // widths 2 2 0 1 0 1
             0,    0,    126,  255,  0x03, 0xE8,              // x: 100, 98, 1100
             0,    0,    133,  128,                           // y: -5, 0, 0
             128,  128,                                       // z
             0x10, 2,    0,    1,                             // types
             0,    1,    2}),                                 // intensities
      3);
  Scan3dCompression compression;
  const auto read = compression.decompress(scan);
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(scan.points.size(), 3U);
  EXPECT_TRUE(same(scan.points[0], {.x = 100, .y = -5, .type = 0x10, .intensity = 8}));
  EXPECT_TRUE(same(scan.points[1], {.x = 98, .y = 0, .type = 0x10, .intensity = 9}));
  EXPECT_TRUE(same(scan.points[2], {.x = 1100, .y = 0, .intensity = 10}));
}

TEST(Scan3dCompression, RefusesWithAReason) {
  Scan3dCompression compression;
  const auto why = [&](std::vector<std::byte> data, i32 points) {
    Scan3dData scan = compressed(std::move(data), points);
    const auto read = compression.decompress(scan);
    return read ? std::string("understood") : read.error().message();
  };
  EXPECT_THAT(why(bytes({1}), 1), HasSubstr("header of stage 3 is missing"));
  EXPECT_THAT(why(bytes({0x4D, 0x31}), 1), HasSubstr("header of stage 1 is missing"));
  EXPECT_THAT(why(bytes({0x4D, 0x43, 0, 0, 0, 0x32, 0, 0, 0, 14, 0, 0, 0, 14}), 1),
              HasSubstr("method 50 of stage 3"));
  EXPECT_THAT(why(bytes({0x4D, 0x31, 1, 0, 0, 5, 0, 0, 0, 20, 0, 0, 0, 14}), 1),
              HasSubstr("invalid points were left out"));
  EXPECT_THAT(why(bytes({0x4D, 0x31, 0, 0, 0, 5, 0, 0, 0, 20, 0, 0, 0, 14}), 1),
              HasSubstr("ends within the points"));
  EXPECT_THAT(why(bytes({0x4D, 0x31, 0, 0, 0, 5, 0, 0, 0, 40, 0, 0, 0, 14}), 1),
              HasSubstr("2 points, but the scan header states 1"));
  EXPECT_THAT(why(bytes({0x4D, 0x31, 0, 0, 0, 4, 0, 0, 0, 20, 0, 0, 0, 14}), 1),
              HasSubstr("method 4 of stage 1"));
  EXPECT_THAT(why(bytes({0x4D, 0x31, 0, 0, 0, 5, 0, 0, 0, 20, 0, 0, 0, 99}), 1),
              HasSubstr("99 bytes, but there are 14"));
  EXPECT_THAT(why({}, -1), HasSubstr("understood")) << "not compressed at all";
  EXPECT_THAT(why(bytes({0}), -1), HasSubstr("-1 points"));
}

// Damaged input is refused or decodes to the number of points that its header states.
TEST(Scan3dCompression, SurvivesDamage) {
  Scan3dCompression compression;
  Scan3dData good = room(10, 91);
  ASSERT_TRUE(compression.compress(good));
  for (unsigned seed = 0; seed < 3000; ++seed) {
    std::mt19937 random(seed);
    Scan3dData scan = good;
    const std::size_t until = random() % 2 == 0 ? 400 : scan.compressedPoints.size();
    for (unsigned i = 0; i <= random() % 3; ++i)
      scan.compressedPoints[random() % until] = static_cast<std::byte>(random());
    if (random() % 4 == 0) scan.compressedPoints.resize(random() % scan.compressedPoints.size());
    scan.compressed = static_cast<i32>(scan.compressedPoints.size());
    if (compression.decompress(scan)) {
      EXPECT_EQ(static_cast<i32>(scan.points.size()), good.pointNum);
    }
  }
}

TEST(Scan3dCompression, AllocatesOnlyOnce) {
  Scan3dCompression compression;
  Scan3dData scan = room(50, 181);
  scan.compressedPoints.reserve_all();
  std::size_t before = 0;
  for (int turn = 0; turn < 5; ++turn) {
    if (turn == 1) before = tims::test::allocations();
    ASSERT_TRUE(compression.compress(scan));
    ASSERT_TRUE(compression.decompress(scan));
  }
  EXPECT_EQ(tims::test::allocations() - before, 0U);
}

}  // namespace scan3d_compression_test
}  // namespace rack
