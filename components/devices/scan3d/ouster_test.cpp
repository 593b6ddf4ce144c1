#include "components/devices/scan3d/ouster.h"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include "components/devices/scan3d/http_get.h"
#include "components/devices/scan3d/spinning_scanner.h"
#include "rack/devices/stream_buffer.h"
#include "rack/devices/virtual_line.h"

namespace rack::device {
namespace ouster_test {

using namespace std::chrono_literals;
using emulator::VirtualLine;
using Bytes = std::vector<std::byte>;

struct Nobody : Output {
  void send(std::span<const std::byte>, std::uint32_t) override { ADD_FAILURE(); }
};

constexpr std::string_view kName = DEVICE_DATA "/ouster/OS-0-32-U1_v2.2.0_1024x10";

std::string metadata_text() {
  std::ifstream file(std::string(kName) + ".json");
  return {std::istreambuf_iterator<char>(file), {}};
}

// Datagrams of a turn: of the scanner and of its gyro.
std::vector<Bytes> packets() {
  gzFile file = ::gzopen((std::string(kName) + ".pcap.gz").c_str(), "rb");
  Bytes all(600'000);
  const int size = ::gzread(file, all.data(), static_cast<unsigned>(all.size()));
  ::gzclose(file);
  all.resize(static_cast<std::size_t>(std::max(0, size)));
  std::vector<Bytes> found;
  for (std::size_t at = 24; at + 16 <= all.size();) {
    const auto length = little_endian<std::uint32_t>(all, at + 8);
    const auto begin = all.begin() + static_cast<std::ptrdiff_t>(at + 16);
    found.emplace_back(begin + 42, begin + static_cast<std::ptrdiff_t>(length));
    at += 16 + length;
  }
  return found;
}

// MD5 (RFC 1321), used for the digests of the manufacturer.
std::string md5(std::span<const std::byte> message) {
  Bytes text(message.begin(), message.end());
  text.push_back(std::byte{0x80});
  while (text.size() % 64 != 56) text.push_back({});
  for (int i = 0; i < 8; ++i) text.push_back(static_cast<std::byte>(message.size() * 8 >> (8 * i)));
  std::array<std::uint32_t, 4> state = {0x67452301, 0xEFCDAB89, 0x98BADCFE, 0x10325476};
  constexpr std::array<std::array<unsigned, 4>, 4> kShifts = {
      {{7, 12, 17, 22}, {5, 9, 14, 20}, {4, 11, 16, 23}, {6, 10, 15, 21}}};
  for (std::size_t block = 0; block < text.size(); block += 64) {
    auto [a, b, c, d] = state;
    for (unsigned i = 0; i < 64; ++i) {
      const unsigned round = i / 16;
      const std::uint32_t f = round == 0   ? (b & c) | (~b & d)
                              : round == 1 ? (d & b) | (~d & c)
                              : round == 2 ? b ^ c ^ d
                                           : c ^ (b | ~d);
      const std::array<unsigned, 4> indices = {i, 5 * i + 1, 3 * i + 5, 7 * i};
      const auto constant = static_cast<std::uint32_t>(std::fabs(std::sin(i + 1.0)) * 4294967296.0);
      const std::uint32_t sum =
          a + f + constant +
          little_endian<std::uint32_t>(text, block + indices.at(round) % 16 * std::size_t{4});
      const unsigned shift = kShifts.at(round).at(i % 4);
      a = d;
      d = c;
      c = b;
      b += sum << shift | sum >> (32 - shift);
    }
    state[0] += a;
    state[1] += b;
    state[2] += c;
    state[3] += d;
  }
  std::string hex;
  for (const std::uint32_t part : state)
    for (int i = 0; i < 4; ++i) {
      std::array<char, 3> two{};
      std::snprintf(two.data(), two.size(), "%02x", part >> (8 * i) & 0xFF);
      hex += two.data();
    }
  return hex;
}

TEST(OusterTest, MetadataOfAScanner) {
  const auto metadata = OusterMetadata::parse(metadata_text());
  ASSERT_TRUE(metadata) << metadata.error().message();
  EXPECT_EQ(metadata->layout.beams, 32U);
  EXPECT_EQ(metadata->layout.columns_of_turn, 1024U);
  EXPECT_EQ(metadata->layout.packet_bytes(), 8448U);
  EXPECT_EQ(metadata->altitudes.front(), 43.88);
  EXPECT_EQ(metadata->azimuths.back(), -4.48);
  EXPECT_EQ(metadata->beam_origin, 27.67);
  EXPECT_EQ(metadata->height, 36.18);
  EXPECT_EQ(metadata->product, "OS-0-32-U1");
}

TEST(OusterTest, InvalidMetadataIsReported) {
  const std::string good = metadata_text();
  EXPECT_FALSE(OusterMetadata::parse(""));
  for (std::size_t size = 0; size < good.size(); size += 3) {
    const auto cut = OusterMetadata::parse(std::string_view(good).substr(0, size));
    EXPECT_TRUE(size >= 700 || !cut) << size;
  }
  std::string other = good;
  other.replace(other.find("SIG16"), 5, "SIG17");
  const auto unknown = OusterMetadata::parse(other);
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().detail(), testing::HasSubstr("SIG17"));
  other = good;
  other.replace(other.find("43.88"), 5, "a3.88");
  EXPECT_FALSE(OusterMetadata::parse(other));
}

TEST(OusterTest, FieldsAreThoseOfTheMakersLibrary) {
  const auto layout = OusterMetadata::parse(metadata_text())->layout;
  Bytes ranges(std::size_t{4} * 32 * 1024);
  Bytes reflectivities(std::size_t{32} * 1024);
  Bytes times(std::size_t{8} * 1024);
  int measured = 0;
  int own = 0;
  for (const Bytes& packet : packets()) {
    if (packet.size() != layout.packet_bytes()) continue;
    ++own;
    for (std::size_t i = 0; i < layout.columns_of_packet; ++i) {
      const OusterColumn column = ouster_column(layout, packet, i);
      ASSERT_TRUE(column.is_valid);
      EXPECT_EQ(column.frame, 1453);
      for (std::size_t b = 0; b < 8; ++b)
        times[std::size_t{8} * column.number + b] = static_cast<std::byte>(column.time >> (8 * b));
      for (std::size_t beam = 0; beam < 32; ++beam) {
        const OusterPixel pixel = ouster_pixel(layout, column, beam);
        measured += pixel.range > 0 ? 1 : 0;
        const std::size_t at = beam * 1024 + column.number;
        reflectivities[at] = static_cast<std::byte>(pixel.reflectivity);
        for (std::size_t b = 0; b < 4; ++b)
          ranges[4 * at + b] = static_cast<std::byte>(pixel.range >> (8 * b));
      }
    }
  }
  EXPECT_EQ(own, 64);
  EXPECT_EQ(measured, 21631);
  EXPECT_EQ(md5(ranges), "b7e7a2a5aa86516f86fd2e8f56b8f6b0");
  EXPECT_EQ(md5(reflectivities), "e0873ecae1da2f575c3918c9b4dc0130");
  EXPECT_EQ(md5(times), "060e7ccbcf80ef9632dec5688e47a6d1");
}

TEST(OusterTest, ATurnIsAScan) {
  Ouster ouster(*OusterMetadata::parse(metadata_text()), {});
  Nobody nobody;
  Time now{100s};
  ouster.start(now, nobody);
  for (const Bytes& packet : packets()) {
    now += 1562us;
    ouster.on_arrival({.bytes = packet, .first = now, .last = now}, nobody);
  }
  Scan3dData scan;
  Time recorded;
  ASSERT_TRUE(ouster.take(scan, recorded));
  EXPECT_EQ(scan.scanNum, 1024);
  EXPECT_EQ(scan.scanPointNum, 32);
  EXPECT_EQ(scan.pointNum, 32768);
  EXPECT_EQ(scan.duration, 99U);
  EXPECT_EQ(std::ranges::count(scan.points, 0, &ScanPoint::type), 21631);
  EXPECT_EQ(ouster.broken(), 10U);  // those of the gyro
}

TEST(OusterTest, SectorsAreJoinedInTheMiddle) {
  const auto all = packets();
  Ouster ouster(*OusterMetadata::parse(metadata_text()), {.sectors = 4});
  Nobody nobody;
  ouster.start(Time(1s), nobody);
  std::vector<int> sectors;
  for (std::size_t i = 5; i < all.size(); ++i) {
    ouster.on_arrival({.bytes = all[i], .last = Time(1s + 2ms * i)}, nobody);
    Scan3dData scan;
    Time recorded;
    if (!ouster.take(scan, recorded)) continue;
    sectors.push_back(scan.sectorIndex);
    EXPECT_EQ(scan.scanNum, 256);
    EXPECT_EQ(scan.sectorNum, 4);
  }
  EXPECT_EQ(sectors, (std::vector<int>{1, 2, 3}));
}

TEST(OusterTest, CutAndFlippedPacketsBreakNothing) {
  const auto packet = packets()[1];
  Ouster ouster(*OusterMetadata::parse(metadata_text()), {.sectors = 64});
  Nobody nobody;
  ouster.start(Time(1s), nobody);
  Scan3dData scan;
  Time recorded;
  for (std::size_t size = 0; size < packet.size(); size += 11)
    ouster.on_arrival({.bytes = std::span(packet).first(size), .last = Time(2s)}, nobody);
  for (std::size_t bit = 0; bit < packet.size() * 8; bit += 3) {
    auto flipped = packet;
    flipped[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    ouster.on_arrival({.bytes = flipped, .last = Time(3s)}, nobody);
    ouster.take(scan, recorded);
  }
}

TEST(OusterTest, TheRoomOfTheEmulatorIsSeen) {
  emulator::OusterScanner scanner;
  Ouster driver(*OusterMetadata::parse(emulator::OusterScanner::metadata()), {});
  VirtualLine line(driver, scanner, {.is_bus = true});
  line.start();
  Scan3dData scan;
  Time recorded;
  const emulator::Room room;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(line.run(1s, [&] { return driver.take(scan, recorded); }));
    EXPECT_EQ(scan.pointNum, 16384);
    EXPECT_NEAR(std::chrono::duration<double>(line.now() - recorded).count(), 0.05, 0.003);
    for (std::size_t at = 0; at < scan.points.size(); at += 53) {
      const ScanPoint& point = scan.points[at];
      const double level = std::hypot(point.x.raw(), point.y.raw());
      EXPECT_NEAR(level, room.distance(std::atan2(point.y.raw(), point.x.raw())), 60);
    }
  }
}

TEST(OusterTest, ItsPageIsAskedFor) {
  emulator::OusterPage page;
  HttpGet get("scanner", "/api/v1/sensor/metadata");
  VirtualLine line(get, page, {.piece = 100, .delay = 1ms});
  line.start();
  ASSERT_TRUE(line.run(1s, [&] { return get.is_done(); }));
  EXPECT_TRUE(OusterMetadata::parse(get.body()));
  HttpGet other("scanner", "/");
  VirtualLine another(other, page, {});
  another.start();
  EXPECT_TRUE(another.run(1s, [&] { return other.failure().has_value(); }));
}

TEST(OusterTest, ALateDatagramOfTheTurnBeforeIsLeftOut) {
  emulator::OusterScanner scanner;
  std::vector<Bytes> sent;
  struct Keeper : Output {
    std::vector<Bytes>& kept;
    explicit Keeper(std::vector<Bytes>& all) : kept(all) {}
    void send(std::span<const std::byte> bytes, std::uint32_t) override {
      kept.emplace_back(bytes.begin(), bytes.end());
    }
  } keeper(sent);
  scanner.start(Time(1s), keeper);
  scanner.on_timeout(Time(1s + 350ms), keeper);
  std::swap(sent[63], sent[65]);
  Ouster driver(*OusterMetadata::parse(emulator::OusterScanner::metadata()), {});
  Nobody nobody;
  driver.start(Time(1s), nobody);
  int scans = 0;
  for (std::size_t i = 0; i < sent.size(); ++i) {
    driver.on_arrival({.bytes = sent[i], .last = Time(1s + 1562500ns * (i + 1))}, nobody);
    Scan3dData scan;
    Time recorded;
    scans += driver.take(scan, recorded) ? 1 : 0;
  }
  EXPECT_EQ(scans, 3);
}

TEST(OusterTest, SilenceIsReported) {
  Ouster scanner(*OusterMetadata::parse(metadata_text()), {});
  Nobody nobody;
  scanner.start(Time(1s), nobody);
  EXPECT_EQ(scanner.next_timeout(), Time(4s));
  scanner.on_timeout(Time(4s), nobody);
  ASSERT_TRUE(scanner.failure());
  EXPECT_THAT(scanner.failure()->detail(), testing::HasSubstr("at this port"));
}

}  // namespace ouster_test
}  // namespace rack::device
