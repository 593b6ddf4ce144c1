#include "components/devices/positioning/ubx.h"

#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "components/devices/core/test_bytes.h"
#include "components/devices/positioning/ublox.h"
#include "rack/devices/pieces.h"

namespace rack::device {
namespace ubx_test {

using namespace std::chrono_literals;

struct Counts {
  std::uint64_t frames = 0;
  std::uint64_t fixes = 0;
  std::uint64_t sentences = 0;
  std::uint64_t broken = 0;
};

Counts counts_of(std::span<const std::byte> bytes, std::size_t piece, UbxStream& stream) {
  Counts counts;
  in_pieces({.bytes = bytes}, piece, [&](const Arrival& arrival) {
    stream.add(arrival);
    UbxFrame frame;
    NmeaSentence sentence;
    for (auto what = stream.next(frame, sentence); what != UbxStream::What::kNothing;
         what = stream.next(frame, sentence))
      if (what == UbxStream::What::kFrame && frame.is(ubx::kNav, ubx::kPvt)) ++counts.fixes;
  });
  counts.frames = stream.frames();
  counts.sentences = stream.sentences();
  counts.broken = stream.broken();
  return counts;
}

// --- recordings, compared with the counts of B5 62 and $ in the files

struct File {
  const char* name;
  std::uint64_t frames;
  std::uint64_t fixes;
  std::uint64_t without_frame;  // false starts of frames
  std::uint64_t sentences;
};

constexpr File kFiles[] = {
    {"2023-4-17_82912_serial-COM3.ubx", 160, 0, 0, 818},
    {"pygpsdata-BADCK2.log", 25, 1, 2, 0},
    {"pygpsdata-BADEOF1.log", 3, 1, 0, 0},
    {"pygpsdata-BADEOF2.log", 2, 1, 1, 0},
    {"pygpsdata-BADHDR.log", 2, 0, 0, 0},
    {"pygpsdata-CFG.log", 21, 0, 0, 0},
    {"pygpsdata-ESF.log", 19, 0, 0, 0},
    {"pygpsdata-HNR.log", 13, 0, 0, 0},
    {"pygpsdata-MIXED-RTCM3.log", 1, 1, 0, 2},
    {"pygpsdata-MIXED-RTCM3BADCRC.log", 1, 1, 0, 2},
    {"pygpsdata-MIXED.log", 300, 39, 0, 8},
    {"pygpsdata-NAV.log", 28, 1, 0, 0},
    {"ucenter-ZEDF9P-configdebug.log", 188, 2, 0, 0},
};

TEST(UbxFilesTest, HaveTheirFramesAndSentences) {
  for (const File& file : kFiles) {
    const auto bytes = bytes_of_file("ubx/" + std::string(file.name));
    ASSERT_FALSE(bytes.empty()) << file.name;
    for (const std::size_t piece : {1U, 16U, 1000U}) {
      UbxStream stream;
      const Counts counts = counts_of(bytes, piece, stream);
      const auto rest = stream.rest();
      const bool is_cut =
          rest.size() > 8 && rest[0] == std::byte{0xB5} && rest[1] == std::byte{0x62};
      EXPECT_EQ(counts.frames, file.frames) << file.name;
      EXPECT_EQ(counts.fixes, file.fixes) << file.name;
      EXPECT_EQ(counts.sentences, file.sentences) << file.name;
      EXPECT_EQ(counts.broken + (is_cut ? 1 : 0), file.without_frame) << file.name;
    }
  }
}

TEST(UbxFilesTest, TheProgramUnderstandsThem) {
  ReceivedOutput out;
  for (const File& file : kFiles) {
    Ublox dialogue({.only_listen = true});
    dialogue.start(Time(1s), out);
    const auto bytes = bytes_of_file("ubx/" + std::string(file.name));
    std::uint64_t taken = 0;
    in_pieces({.bytes = bytes}, 16, [&](const Arrival& arrival) {
      dialogue.on_arrival(arrival, out);
      GpsData data;
      Time recorded;
      taken += dialogue.take(data, recorded) ? 1 : 0;
    });
    EXPECT_GE(taken, file.fixes) << file.name;
    if (file.sentences > 100) {
      EXPECT_GT(taken, 50U) << file.name;  // from NMEA if there is no NAV-PVT
    }
  }
  EXPECT_TRUE(out.sent.empty());
}

// --- frames

// Frames from u-blox documents.
TEST(UbxTest, KnownFrames) {
  std::vector<std::byte> frame;
  append_ubx(frame, ubx::kMon, ubx::kVersion, {});
  EXPECT_EQ(frame, bytes_of_hex("B5620A0400000E34"));
  frame.clear();
  append_ubx(frame, ubx::kCfg, ubx::kCfgRate, bytes_of_hex("C80001000100"));
  EXPECT_EQ(frame, bytes_of_hex("B56206080600C80001000100DE6A"));
  frame.clear();
  append_ubx(frame, ubx::kCfg, ubx::kCfgMessage, bytes_of_hex("010701"));
  EXPECT_EQ(frame, bytes_of_hex("B562060103000107011351"));
}

TEST(UbxTest, SizesOfValues) {
  EXPECT_EQ(ubx_value_size(ubx::kUbxOutOfUart1), 1U);
  EXPECT_EQ(ubx_value_size(ubx::kPvtAtUart1), 1U);
  EXPECT_EQ(ubx_value_size(ubx::kMillisecondsOfFix), 2U);
  EXPECT_EQ(ubx_value_size(ubx::kBaudOfUart1), 4U);
  EXPECT_EQ(ubx_value_size(0x50000000), 8U);
  EXPECT_EQ(ubx_value_size(0), 0U);
}

std::vector<std::byte> pvt() {
  std::vector<std::byte> payload(92);
  const auto set = [&](std::size_t at, std::int64_t value, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i)
      payload[at + i] = static_cast<std::byte>(value >> (8 * i));
  };
  set(4, 2024, 2);
  set(6, 2, 1);
  set(7, 29, 1);
  set(8, 23, 1);
  set(9, 59, 1);
  set(10, 58, 1);
  set(11, 7, 1);
  set(16, 200'000'000, 4);
  set(20, 3, 1);
  set(21, 0x83, 1);
  set(23, 17, 1);
  set(24, 97'170'000, 4);
  set(28, -523'820'000, 4);
  set(36, -1500, 4);
  set(40, 14, 4);
  set(44, 21, 4);
  set(60, 1234, 4);
  set(64, 9'000'000, 4);
  set(72, 100'000, 4);
  set(76, 123, 2);
  return payload;
}

TEST(UbxTest, AFix) {
  constexpr double kDegree = std::numbers::pi / 180;
  GpsData data;
  GpsMoment moment;
  ASSERT_TRUE(decode_ubx_pvt(pvt(), data, moment));
  EXPECT_EQ(data.mode, gps_mode::k3d + gps_mode::kDifferential);
  EXPECT_NEAR(data.longitude, 9.717 * kDegree, 1e-9);
  EXPECT_NEAR(data.latitude, -52.382 * kDegree, 1e-9);
  EXPECT_EQ(data.altitude, -1500);
  EXPECT_EQ(data.speed, 1234);
  EXPECT_NEAR(data.heading, 90 * kDegree, 1e-6);
  EXPECT_EQ(data.satelliteNum, 17);
  EXPECT_NEAR(data.pdop, 1.23, 1e-6);
  EXPECT_EQ(data.var.x, 14);
  EXPECT_EQ(data.var.z, 21);
  EXPECT_EQ(data.utcTime, 1709251198);
  EXPECT_EQ(moment.fraction(), 200ms);
  auto lost = pvt();
  lost[21] = std::byte{0};
  ASSERT_TRUE(decode_ubx_pvt(lost, data, moment));
  EXPECT_EQ(data.mode, gps_mode::kInvalid);
  EXPECT_FALSE(decode_ubx_pvt(std::span(lost).first(83), data, moment));
}

TEST(UbxTest, EverySplitAndEveryFlippedBit) {
  std::vector<std::byte> stream = bytes_of_hex("D300B5");
  std::vector<std::byte> frame;
  append_ubx(frame, ubx::kNav, ubx::kPvt, pvt());
  append_nmea(frame, "GNGLL,5310.8115,N,00525.7025,E,195719,A,A");
  stream.insert(stream.end(), frame.begin(), frame.end());
  for (std::size_t cut = 0; cut <= stream.size(); ++cut) {
    UbxStream ubx;
    Counts counts = counts_of(std::span(stream).first(cut), 1000, ubx);
    counts = counts_of(std::span(stream).subspan(cut), 1000, ubx);
    EXPECT_EQ(counts.frames, 1U) << cut;
    EXPECT_EQ(counts.sentences, 1U) << cut;
  }
  for (std::size_t i = 0; i < frame.size() * 8; ++i) {
    auto flipped = frame;
    flipped[i / 8] ^= static_cast<std::byte>(1 << i % 8);
    for (int again = 0; again < 50; ++again)
      flipped.insert(flipped.end(), frame.begin(), frame.end());
    UbxStream ubx;
    const Counts counts = counts_of(flipped, 1000, ubx);
    EXPECT_GE(counts.frames, 50U) << i;
    EXPECT_LE(counts.frames + counts.sentences, i / 8 >= frame.size() - 4 ? 102U : 101U) << i;
  }
}

TEST(UbxTest, AWrongLengthIsNotWaitedForLong) {
  UbxStream ubx;
  UbxFrame frame;
  NmeaSentence sentence;
  const auto broken = bytes_of_hex("B5620107FF0F0102");
  ubx.add({.bytes = broken, .first = Time(10s), .last = Time(10s)});
  EXPECT_EQ(ubx.next(frame, sentence), UbxStream::What::kNothing);
  std::vector<std::byte> good;
  append_ubx(good, ubx::kNav, ubx::kPvt, pvt());
  ubx.add({.bytes = good, .first = Time(11s), .last = Time(11s)});
  EXPECT_EQ(ubx.next(frame, sentence), UbxStream::What::kNothing);
  ubx.add({.bytes = good, .first = Time(13s), .last = Time(13s)});
  EXPECT_EQ(ubx.next(frame, sentence), UbxStream::What::kFrame);
  EXPECT_EQ(ubx.next(frame, sentence), UbxStream::What::kFrame);
}

TEST(UbxTest, NoiseBreaksNothing) {
  std::mt19937 random(1);
  ReceivedOutput out;
  Ublox dialogue({});
  Time now{1000s};
  dialogue.start(now, out);
  constexpr std::string_view kLikely = "\xB5\x62\x01\x07$*,\n";
  for (int i = 0; i < 20000; ++i) {
    std::vector<std::byte> noise(random() % 100);
    for (std::byte& byte : noise)
      byte = static_cast<std::byte>(random() % 2 == 0 ? kLikely[random() % kLikely.size()]
                                                      : static_cast<char>(random()));
    now += 10ms;
    dialogue.on_arrival({.bytes = noise, .first = now, .last = now}, out);
    if (dialogue.next_timeout() <= now) dialogue.on_timeout(now, out);
    if (dialogue.failure()) dialogue.start(now, out);
  }
}

}  // namespace ubx_test
}  // namespace rack::device
