#include "components/devices/scanners/lms200.h"

#include <fstream>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/text.h"
#include "components/devices/core/virtual_line.h"
#include "components/devices/scanners/lms200_emulator.h"

namespace rack::device {
namespace lms200_test {

using namespace std::chrono_literals;

std::vector<std::byte> bytes_of(std::initializer_list<int> values) {
  std::vector<std::byte> bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

std::vector<std::byte> measurement(std::size_t values, unsigned flags, int distance) {
  const auto count_and_flags = static_cast<unsigned>(values) | flags;
  std::vector<std::byte> body = bytes_of(
      {0xB0, static_cast<int>(count_and_flags & 0xFF), static_cast<int>(count_and_flags >> 8)});
  for (std::size_t i = 0; i < values; ++i) {
    const int value = distance + static_cast<int>(i);
    body.push_back(static_cast<std::byte>(value));
    body.push_back(static_cast<std::byte>(value >> 8));
  }
  body.push_back(std::byte{0x10});
  return body;
}

std::vector<std::byte> telegram(std::span<const std::byte> body) {
  std::vector<std::byte> bytes;
  append_lms200(bytes, body, 0x80);
  return bytes;
}

constexpr unsigned kMillimetres = 0x4000;

TEST(Lms200Test, AScanGoesClockwise) {
  LadarData scan;
  ASSERT_TRUE(decode_lms200_scan(measurement(181, kMillimetres, 1000), scan));
  ASSERT_EQ(scan.points.size(), 181U);
  EXPECT_NEAR(scan.startAngle, -std::numbers::pi / 2, 1e-6);
  EXPECT_NEAR(scan.endAngle, std::numbers::pi / 2, 1e-6);
  EXPECT_EQ(scan.points[180].distance, 1000);  // the first value is on the right
  EXPECT_EQ(scan.points[0].distance, 1180);
  EXPECT_NEAR(scan.points[90].angle, 0, 1e-6);
  EXPECT_EQ(scan.duration, 6U);
}

// One, two or four turns of 13.3 ms: numbers of the original.
TEST(Lms200Test, AFineScanTakesSeveralTurns) {
  for (const auto& [values, milliseconds] :
       {std::pair{181, 6U}, {180, 6U}, {101, 3U}, {100, 3U}, {201, 17U}, {361, 20U}, {401, 43U}}) {
    LadarData scan;
    ASSERT_TRUE(decode_lms200_scan(
        measurement(static_cast<std::size_t>(values), kMillimetres, 1000), scan));
    EXPECT_EQ(scan.duration, milliseconds) << values;
  }
}

TEST(Lms200Test, CentimetresFlagsAndCodes) {
  LadarData scan;
  auto body = measurement(101, 0, 250);
  body[3] = std::byte{0xFA};  // 250 with the flag of a reflector
  body[4] = std::byte{0x20};
  body[5] = std::byte{0xFF};  // 8191: out of range
  body[6] = std::byte{0x1F};
  ASSERT_TRUE(decode_lms200_scan(body, scan));
  EXPECT_EQ(scan.points[100].distance, 2500);
  EXPECT_EQ(scan.points[100].type, ladar_point::kReflector);
  EXPECT_EQ(scan.points[99].type, ladar_point::kInvalid);
  EXPECT_EQ(scan.points[98].distance, 2520);
  EXPECT_NEAR(scan.endAngle - scan.startAngle, 100 * std::numbers::pi / 180, 1e-6);
}

TEST(Lms200Test, PartsOfAnInterlacedScanAreAQuarterDegreeApart) {
  LadarData first;
  LadarData second;
  ASSERT_TRUE(decode_lms200_scan(measurement(181, kMillimetres, 1000), first));
  ASSERT_TRUE(decode_lms200_scan(measurement(181, kMillimetres | 1 << 11, 1000), second));
  EXPECT_NEAR(first.endAngle - second.endAngle, 0.25 * std::numbers::pi / 180, 1e-6);
}

TEST(Lms200Test, WhatIsNoScanIsNone) {
  LadarData scan;
  const auto body = measurement(181, kMillimetres, 1000);
  for (std::size_t size = 0; size < 3 + 2 * 181; ++size)
    EXPECT_FALSE(decode_lms200_scan(std::span(body).first(size), scan)) << size;
  EXPECT_FALSE(decode_lms200_scan(measurement(182, kMillimetres, 1000), scan));
  EXPECT_FALSE(decode_lms200_scan(bytes_of({0xB1, 181, 0x40}), scan));
}

TEST(Lms200Test, EverySplitGivesTheSameTelegrams) {
  std::vector<std::byte> stream = bytes_of({0x06, 0x02, 0x77, 0x15});
  for (int i = 0; i < 3; ++i) {
    const auto one = telegram(measurement(101, kMillimetres, 100 * i));
    stream.insert(stream.end(), one.begin(), one.end());
  }
  for (std::size_t cut = 0; cut <= stream.size(); ++cut) {
    Lms200Telegrams telegrams;
    int found = 0;
    for (const auto piece : {std::span(stream).first(cut), std::span(stream).subspan(cut)}) {
      telegrams.add({.bytes = piece});
      Lms200Telegram one;
      for (auto what = telegrams.next(one); what != Lms200Telegrams::What::kNothing;
           what = telegrams.next(one))
        found += what == Lms200Telegrams::What::kTelegram ? 1 : 0;
    }
    EXPECT_EQ(found, 3) << cut;
  }
}

TEST(Lms200Test, AFlippedBitCostsOneTelegram) {
  const auto one = telegram(measurement(101, kMillimetres, 1000));
  for (std::size_t i = 0; i < one.size() * 8; ++i) {
    auto stream = one;
    stream[i / 8] ^= static_cast<std::byte>(1 << i % 8);
    // A false start with a long length is detected only after so many bytes.
    for (int again = 0; again < 4; ++again) stream.insert(stream.end(), one.begin(), one.end());
    Lms200Telegrams telegrams;
    telegrams.add({.bytes = stream});
    Lms200Telegram got;
    int found = 0;
    for (auto what = telegrams.next(got); what != Lms200Telegrams::What::kNothing;
         what = telegrams.next(got))
      found += what == Lms200Telegrams::What::kTelegram ? 1 : 0;
    EXPECT_GE(found, 4) << i;
    EXPECT_LE(found, i / 8 == 1 ? 5 : 4) << i;
  }
}

TEST(Lms200Test, ARealTelegram) {
  std::ifstream file(DEVICE_DATA "/sick/lms200-one-telegram.hex");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto bytes = tims::base::parse_hex(text);
  ASSERT_TRUE(bytes);
  ASSERT_EQ(bytes->size(), 732U);
  Lms200Telegrams telegrams;
  telegrams.add({.bytes = *bytes});
  Lms200Telegram got;
  ASSERT_EQ(telegrams.next(got), Lms200Telegrams::What::kTelegram);
  EXPECT_EQ(got.body.size(), 726U);
  LadarData scan;
  ASSERT_TRUE(decode_lms200_scan(got.body, scan));
  EXPECT_EQ(scan.points.size(), 361U);
  EXPECT_NEAR(scan.endAngle, std::numbers::pi / 2, 1e-6);
  EXPECT_EQ(telegrams.broken(), 0U);
}

// --- The dialogue with an emulated scanner

using emulator::Lms200Emulator;
using emulator::Lms200EmulatorSettings;
using emulator::VirtualLine;

// Driver, scanner and the serial line between them.
struct Pair {
  explicit Pair(const Lms200Settings& host_settings, const Lms200EmulatorSettings& settings = {},
                std::size_t piece = 0)
      : host(host_settings),
        scanner(settings),
        line(host, scanner,
             {.has_rate = true, .host_baud = 9600, .device_baud = settings.baud, .piece = piece}) {}

  bool run_until_ready(Duration at_most = 60s) {
    line.start();
    return line.run(at_most, [&] { return host.is_ready() || host.failure(); }) && host.is_ready();
  }
  // Number of scans per second; stores the last scan.
  double scans_per_second(Duration how_long = 4s) {
    std::size_t taken = 0;
    line.run(how_long, [&] {
      Time time;
      taken += host.take(scan, time) ? 1U : 0U;
      return false;
    });
    return static_cast<double>(taken) / std::chrono::duration<double>(how_long).count();
  }
  std::string failure() const { return host.failure() ? host.failure()->detail() : ""; }

  Lms200 host;
  Lms200Emulator scanner;
  VirtualLine line;
  LadarData scan;
};

TEST(Lms200DialogueTest, BringsAScannerToItsRateAndStartsIt) {
  for (const std::uint32_t rate : {9600U, 19200U, 38400U, 500000U})
    for (const std::uint32_t rate_before : {9600U, rate}) {
      Pair pair({.baud = rate}, {.baud = rate_before});
      ASSERT_TRUE(pair.run_until_ready()) << rate << pair.failure();
      EXPECT_EQ(pair.scanner.baud(), rate);
      EXPECT_EQ(pair.line.host_baud(), rate);
      EXPECT_TRUE(pair.scanner.is_logged_in());
      EXPECT_TRUE(pair.scanner.measures());
    }
}

TEST(Lms200DialogueTest, AScannerMayBeSlow) {
  Pair pair({.baud = 500000}, {.answer_time = 900ms});
  EXPECT_TRUE(pair.run_until_ready()) << pair.failure();
}

TEST(Lms200DialogueTest, SendsWhatTheLineCarries) {
  const emulator::Room room;
  Pair fast({.baud = 500000, .mode = Lms200Mode::kFast}, {}, 64);
  ASSERT_TRUE(fast.run_until_ready());
  EXPECT_NEAR(fast.scans_per_second(), 75, 0.6);
  for (const LadarPoint& point : fast.scan.points)
    EXPECT_NEAR(point.distance, room.distance(point.angle), 1);

  Pair whole({.baud = 500000});
  ASSERT_TRUE(whole.run_until_ready());
  EXPECT_NEAR(whole.scans_per_second(), 37.5, 0.6);
  EXPECT_EQ(whole.scan.points.size(), 361U);

  Pair slow({.baud = 38400}, {.is_indoor = false});
  ASSERT_TRUE(slow.run_until_ready());
  EXPECT_NEAR(slow.scans_per_second(), 5, 0.6);  // 732 bytes, 191 ms
  for (const LadarPoint& point : slow.scan.points)
    EXPECT_NEAR(point.distance, room.distance(point.angle), 6);
}

TEST(Lms200DialogueTest, PartsOfAScanTakeTurns) {
  Pair pair({.baud = 500000, .mode = Lms200Mode::kInterlaced});
  ASSERT_TRUE(pair.run_until_ready());
  std::array<std::size_t, 2> parts{};
  pair.line.run(1s, [&] {
    Time time;
    if (pair.host.take(pair.scan, time)) ++parts[pair.scan.points.size() == 181 ? 0 : 1];
    return false;
  });
  EXPECT_NEAR(static_cast<double>(parts[0]), 37, 1);
  EXPECT_NEAR(static_cast<double>(parts[1]), 37, 1);
}

TEST(Lms200DialogueTest, AnythingLostIsAskedForAgain) {
  for (int lost = 0; lost < 9; ++lost) {
    Pair pair({.baud = 500000});
    int sent = 0;
    pair.line.set_lose([&](bool, std::span<const std::byte>) { return sent++ == lost; });
    EXPECT_TRUE(pair.run_until_ready()) << lost << pair.failure();
  }
}

// A crashed program has left the scanner measuring at the fast rate.
TEST(Lms200DialogueTest, AScannerThatIsSendingIsTakenOver) {
  Pair pair({.baud = 500000});
  ASSERT_TRUE(pair.run_until_ready());
  pair.line.start_host();
  EXPECT_FALSE(pair.host.is_ready());
  EXPECT_TRUE(pair.line.run(60s, [&] { return pair.host.is_ready(); }));
  EXPECT_GT(pair.scans_per_second(), 30);
  pair.line.stop_host();
  pair.line.run(200ms);
  EXPECT_FALSE(pair.scanner.measures());
}

TEST(Lms200DialogueTest, AMissingAnswerIsReported) {
  Pair pair({.baud = 38400}, {.baud = 19200});
  int sent = 0;
  pair.line.set_lose([&](bool from_host, std::span<const std::byte>) {
    sent += from_host ? 1 : 0;
    return false;
  });
  EXPECT_FALSE(pair.run_until_ready());
  EXPECT_THAT(pair.failure(), testing::HasSubstr("neither at 9600 nor at 38400"));
  EXPECT_EQ(sent, 6);
}

TEST(Lms200DialogueTest, ARefusedRateIsReported) {
  Pair pair({.baud = 500000}, {.refuses_rates = true});
  EXPECT_FALSE(pair.run_until_ready());
  EXPECT_THAT(pair.failure(), testing::HasSubstr("refuses 500000 baud"));
}

struct CountingOutput : Output {
  void send(std::span<const std::byte>, std::uint32_t) override { ++sent; }
  int sent = 0;
};

TEST(Lms200DialogueTest, AScanIsOfTheTimeWhenTheMirrorWasInItsMiddle) {
  const Time now{1000s};
  CountingOutput output;
  Lms200 dialogue({.only_listen = true});
  dialogue.start(now, output);
  EXPECT_FALSE(dialogue.is_ready());
  const auto bytes = telegram(measurement(181, kMillimetres, 1000));
  dialogue.on_arrival({.bytes = bytes, .first = now - 7440us, .last = now}, output);
  LadarData scan;
  Time recorded;
  EXPECT_TRUE(dialogue.is_ready());
  ASSERT_TRUE(dialogue.take(scan, recorded));
  EXPECT_EQ(recorded, now - 7440us - 3ms);
  EXPECT_FALSE(dialogue.take(scan, recorded));
  EXPECT_EQ(output.sent, 0);
}

TEST(Lms200DialogueTest, NoiseBreaksNothing) {
  std::mt19937 random(1);
  Time now{1000s};
  CountingOutput output;
  Lms200 dialogue({.baud = 500000});
  dialogue.start(now, output);
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::byte> noise(random() % 200);
    for (std::byte& byte : noise) byte = static_cast<std::byte>(random() % 8);
    now += 10ms;
    dialogue.on_arrival({.bytes = noise, .first = now, .last = now}, output);
    if (dialogue.next_timeout() <= now) dialogue.on_timeout(now, output);
    if (dialogue.failure()) dialogue.start(now, output);
  }
}

}  // namespace lms200_test
}  // namespace rack::device
