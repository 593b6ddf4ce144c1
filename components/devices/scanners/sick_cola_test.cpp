#include "components/devices/scanners/sick_cola.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/scanners/sick_captured.h"
#include "components/devices/scanners/sick_cola_emulator.h"
#include "rack/devices/virtual_line.h"

namespace rack::device {
namespace sick_cola_test {

using namespace std::chrono_literals;
using emulator::LineSettings;
using emulator::SickColaEmulator;
using emulator::SickColaEmulatorSettings;
using emulator::VirtualLine;

// A driver, a scanner and the network between them.
struct Pair {
  explicit Pair(const SickColaSettings& host_settings = {},
                const SickColaEmulatorSettings& scanner_settings = {},
                const LineSettings& line_settings = {})
      : host(host_settings), scanner(scanner_settings), line(host, scanner, line_settings) {}

  bool run_until_ready(Duration at_most = 30s) {
    line.start();
    return line.run(at_most, [&] { return host.is_ready() || host.failure(); }) && host.is_ready();
  }
  std::string failure() const { return host.failure() ? host.failure()->detail() : ""; }

  SickCola host;
  SickColaEmulator scanner;
  VirtualLine line;
};

bool contains(std::span<const std::byte> bytes, std::string_view text) {
  const std::string_view all(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return all.find(text) != std::string_view::npos;
}

TEST(SickColaTest, BringsAScannerToSendItsScans) {
  for (const ColaDialect dialect : {ColaDialect::kBinary, ColaDialect::kAscii}) {
    Pair pair({}, {.dialect = dialect});
    ASSERT_TRUE(pair.run_until_ready()) << pair.failure();
    EXPECT_EQ(pair.host.dialect(), dialect);
    EXPECT_EQ(pair.host.identity(), "LMS111 V1.80");
    EXPECT_FALSE(pair.scanner.is_logged_in());  // logged out again
    EXPECT_EQ(pair.scanner.errors_sent(), 0U);
    EXPECT_EQ(pair.host.take_notes(), "");
    EXPECT_EQ(pair.host.scan().channel_count, 2U);
    EXPECT_TRUE(pair.host.scan().channels[1].is_wide);

    LadarData scan;
    Time recorded;
    ASSERT_TRUE(pair.host.take(scan, recorded));
    EXPECT_FALSE(pair.host.take(scan, recorded));
    const emulator::Room room;
    for (const LadarPoint& point : scan.points)
      EXPECT_NEAR(point.distance, room.distance(point.angle), 1);
    EXPECT_EQ(scan.points.size(), 541U);
    EXPECT_EQ(scan.duration, 15U);

    const std::size_t before = pair.scanner.scans_sent();
    pair.line.run(10s);
    EXPECT_NEAR(static_cast<double>(pair.scanner.scans_sent() - before), 500, 1);
    pair.line.stop_host();
    pair.line.run(100ms);
    EXPECT_FALSE(pair.scanner.sends_scans());
  }
}

TEST(SickColaTest, UsesOnlyTheConfiguredDialect) {
  Pair good({.dialect = ColaDialect::kAscii}, {.dialect = ColaDialect::kAscii});
  EXPECT_TRUE(good.run_until_ready());
  Pair bad({.dialect = ColaDialect::kAscii}, {.dialect = ColaDialect::kBinary});
  EXPECT_FALSE(bad.run_until_ready());
  EXPECT_THAT(bad.failure(), testing::HasSubstr("protocol=0 tries both"));
}

TEST(SickColaTest, EveryPieceOfEveryAnswerMayComeAlone) {
  for (const std::size_t piece : {1U, 2U, 7U, 100U, 1448U}) {
    Pair pair({}, {}, {.piece = piece});
    EXPECT_TRUE(pair.run_until_ready()) << piece << pair.failure();
  }
}

TEST(SickColaTest, AnyLostTelegramIsAskedForAgain) {
  for (int lost = 0; lost < 14; ++lost) {
    Pair pair;
    int sent = 0;
    pair.line.set_lose([&](bool, std::span<const std::byte>) { return sent++ == lost; });
    EXPECT_TRUE(pair.run_until_ready()) << lost << pair.failure();
  }
}

TEST(SickColaTest, AScannerMayBeSlow) {
  Pair pair({}, {.answer_time = 450ms, .spin_up = 15s});
  EXPECT_TRUE(pair.run_until_ready(60s)) << pair.failure();
  EXPECT_EQ(pair.scanner.errors_sent(), 0U);
}

// Sends everything twice.
class Stutterer final : public Dialogue, private Output {
 public:
  void start(Time now, Output& out) override { inner_.start(now, use(out)); }
  void on_arrival(const Arrival& arrival, Output& out) override {
    inner_.on_arrival(arrival, use(out));
  }
  void on_timeout(Time now, Output& out) override { inner_.on_timeout(now, use(out)); }
  [[nodiscard]] Time next_timeout() const override { return inner_.next_timeout(); }

 private:
  Output& use(Output& out) {
    out_ = &out;
    return *this;
  }
  void send(std::span<const std::byte> bytes, std::uint32_t id) override {
    out_->send(bytes, id);
    out_->send(bytes, id);
  }

  SickColaEmulator inner_;
  Output* out_ = nullptr;
};

TEST(SickColaTest, AnswersMayComeTwice) {
  SickCola host({});
  Stutterer scanner;
  VirtualLine line(host, scanner, {});
  line.start();
  EXPECT_TRUE(line.run(30s, [&] { return host.is_ready(); }));
  EXPECT_EQ(host.take_notes(), "");
}

TEST(SickColaTest, AnUnansweredRequestIsNamed) {
  Pair nobody;
  nobody.line.set_lose([](bool, std::span<const std::byte>) { return true; });
  EXPECT_FALSE(nobody.run_until_ready());
  EXPECT_THAT(nobody.failure(), testing::HasSubstr("neither in CoLa B nor in CoLa A"));

  Pair unresponsive;
  unresponsive.line.set_lose([](bool from_host, std::span<const std::byte> bytes) {
    return from_host && contains(bytes, "LMCstartmeas");
  });
  EXPECT_FALSE(unresponsive.run_until_ready());
  EXPECT_EQ(unresponsive.failure(), "the scanner has stopped answering, at request LMCstartmeas");
  // When it answers again, the setup starts from the beginning.
  unresponsive.line.set_lose(nullptr);
  unresponsive.line.start_host();
  EXPECT_TRUE(unresponsive.line.run(30s, [&] { return unresponsive.host.is_ready(); }));
}

TEST(SickColaTest, TriesTheOtherPassword) {
  Pair pair({}, {.password = 0x6FD62C05});
  EXPECT_TRUE(pair.run_until_ready());
  EXPECT_EQ(pair.host.take_notes(), "");
}

TEST(SickColaTest, AScannerThatMeasuresAlreadyNeedsNoPassword) {
  Pair owner;
  ASSERT_TRUE(owner.run_until_ready());
  // A client without the password connects to the same scanner.
  Pair pair({}, {.password = 1});
  EXPECT_FALSE(pair.run_until_ready(40s));
  EXPECT_THAT(pair.host.take_notes(), testing::HasSubstr("accepts none of the default passwords"));
  EXPECT_THAT(pair.failure(), testing::HasSubstr("sends no scan"));
  EXPECT_TRUE(pair.scanner.sends_scans());  // subscribed, but the laser is off
}

TEST(SickColaTest, TakesRemissionIn8BitsWhereThereIsNoOther) {
  Pair pair({.view = {.reflector_remission = 100}}, {.has_wide_remission = false});
  ASSERT_TRUE(pair.run_until_ready()) << pair.failure();
  EXPECT_EQ(pair.scanner.errors_sent(), 1U);
  EXPECT_EQ(pair.host.errors(), 1U);
  EXPECT_FALSE(pair.host.scan().channels[1].is_wide);
  LadarData scan;
  Time recorded;
  ASSERT_TRUE(pair.host.take(scan, recorded));
  EXPECT_EQ(scan.points[0].intensity, 100);
  EXPECT_EQ(scan.points[0].type, ladar_point::kReflector);
}

TEST(SickColaTest, AnotherScannerIsRefusedByItsNumber) {
  Pair pair({.serial_number = 5}, {.serial_number = 6});
  EXPECT_FALSE(pair.run_until_ready());
  EXPECT_EQ(pair.failure(), "this scanner has serial number 6; required: 5");
  Pair right({.serial_number = 6}, {.serial_number = 6});
  EXPECT_TRUE(right.run_until_ready());
}

TEST(SickColaTest, AScanIsOfTheTimeWhenItWasMeasured) {
  Pair pair;
  ASSERT_TRUE(pair.run_until_ready());
  LadarData scan;
  Time recorded;
  Duration worst{};
  // The network delays each piece differently: the least delayed one determines the time.
  std::mt19937 random(1);
  SickCola host({.only_listen = true});
  struct Discard : Output {
    void send(std::span<const std::byte>, std::uint32_t) override {}
  } discard;
  host.start({}, discard);
  struct Relay : Output {
    void send(std::span<const std::byte> bytes, std::uint32_t) override {
      sent.assign(bytes.begin(), bytes.end());
    }
    std::vector<std::byte> sent;
  } relay;
  for (int i = 0; i < 500; ++i) {
    const Time now = pair.scanner.next_timeout();
    pair.scanner.on_timeout(now, relay);
    const Duration delay(random() % 10 == 0 ? 100000 : 100000 + random() % 9000000);
    host.on_arrival({.bytes = relay.sent, .first = now + delay, .last = now + delay}, discard);
    ASSERT_TRUE(host.take(scan, recorded));
    if (i > 50) worst = std::max(worst, std::chrono::abs(recorded - pair.scanner.measured()));
  }
  EXPECT_LT(worst, 700us);  // includes 500 us, because the duration is rounded to milliseconds
}

TEST(SickColaTest, AStuckCounterIsNotUsedAsTime) {
  SickCola host({.only_listen = true});
  struct Discard : Output {
    void send(std::span<const std::byte>, std::uint32_t) override {}
  } discard;
  host.start({}, discard);
  const auto scans = emulator::scans_of_cola(stream_of(captured("lms111.cola-b.txt")), 1);
  std::vector<std::byte> body;
  append_cola_scan(body, ColaDialect::kBinary, scans.at(0));
  std::vector<std::byte> telegram;
  append_cola(telegram, ColaDialect::kBinary, body);
  Time now{100s};
  for (int i = 0; i < 5; ++i, now += 1s) {
    host.on_arrival({.bytes = telegram, .first = now, .last = now}, discard);
    LadarData scan;
    Time recorded;
    ASSERT_TRUE(host.take(scan, recorded));
    EXPECT_GT(recorded, now - 20ms);
    EXPECT_LE(recorded, now);
  }
}

// A whole recording with both directions, as it is played.
TEST(SickColaTest, TakesAllScansOfARecording) {
  constexpr std::array<std::pair<const char*, std::size_t>, 4> kFiles = {
      {{"lms111.cola-b.txt", 97},
       {"lms511-a.cola-b.txt", 32},
       {"lms511.cola-b.txt", 32},
       {"tim781s.cola-b.txt", 33}}};
  for (const auto& [file, scans] : kFiles) {
    SickCola host({.only_listen = true});
    struct Quiet : Output {
      void send(std::span<const std::byte>, std::uint32_t) override { ADD_FAILURE(); }
    } quiet;
    host.start({}, quiet);
    EXPECT_FALSE(host.is_ready());
    std::size_t taken = 0;
    std::optional<Time> before;
    for (const CaptureRecord& record : captured(file)) {
      const Time now = Time(1000s) + record.time;
      host.on_arrival({.bytes = record.bytes, .first = now, .last = now}, quiet);
      LadarData scan;
      Time recorded;
      if (!host.take(scan, recorded)) continue;
      ++taken;
      EXPECT_LT(recorded, now);
      EXPECT_GT(recorded, now - 150ms) << taken;
      EXPECT_GT(recorded, before.value_or(Time(0s)));
      before = recorded;
    }
    EXPECT_EQ(taken, scans) << file;
    EXPECT_TRUE(host.is_ready());
  }
}

// A post 1 m ahead in a room 5 m wide, with and without the scanner's name.
TEST(SickColaTest, WhatIsAheadOfEveryScannerIsAtZero) {
  struct Case {
    const char* name;
    std::int32_t start;
    std::uint16_t step;
    std::size_t ahead;
    std::size_t count;
  };
  for (const Case& one :
       {Case{"TiM240", -1200000, 10000, 120, 241}, Case{"", -1200000, 10000, 120, 241},
        Case{"TiM561", -450000, 10000, 135, 271}, Case{"", -450000, 10000, 135, 271},
        Case{"LRS4581", -1800000, 10000, 180, 361}, Case{"TiM240", -300000, 10000, 30, 61},
        Case{"NAV310", 0, 10000, 180, 360}}) {
    ColaScan scan;
    scan.channels.emplace_back();
    scan.channel_count = 1;
    ColaChannel& channel = scan.channels[0];
    std::ranges::copy(std::string_view("DIST1"), channel.content.begin());
    channel.start_angle = one.start;
    channel.step = one.step;
    channel.values.assign(one.count, 5000);
    channel.values[one.ahead] = 1000;
    channel.values[one.ahead + 10] = 2000;
    std::vector<std::byte> body;
    std::vector<std::byte> bytes;
    if (*one.name != '\0') {
      ColaWriter(ColaDialect::kAscii, body, "sRA DeviceIdent").put_string(one.name);
      append_cola(bytes, ColaDialect::kAscii, body);
      body.clear();
    }
    append_cola_scan(body, ColaDialect::kAscii, scan);
    append_cola(bytes, ColaDialect::kAscii, body);

    SickCola host({.only_listen = true});
    struct Discard : Output {
      void send(std::span<const std::byte>, std::uint32_t) override {}
    } discard;
    host.start({}, discard);
    host.on_arrival({.bytes = bytes, .first = Time(1s), .last = Time(1s)}, discard);
    LadarData data;
    Time recorded;
    ASSERT_TRUE(host.take(data, recorded)) << one.name;
    const auto at = [&](i32 distance) {
      return std::ranges::find(
                 data.points, distance,
                 [](const LadarPoint& point) { return static_cast<i32>(point.distance); })
          ->angle;
    };
    constexpr double kTen = 10 * std::numbers::pi / 180;
    EXPECT_NEAR(at(1000), 0, 1e-4) << one.name << one.start;
    EXPECT_NEAR(at(2000), host.front().is_clockwise ? kTen : -kTen, 1e-4) << one.name;
    EXPECT_LT(data.points.front().angle, data.points.back().angle);
  }
}

TEST(SickColaTest, TheFrontCanBeGiven) {
  Pair pair({.front = 45});
  ASSERT_TRUE(pair.run_until_ready()) << pair.failure();
  LadarData scan;
  Time recorded;
  ASSERT_TRUE(pair.host.take(scan, recorded));
  EXPECT_NEAR(scan.startAngle, (45 - 225) * std::numbers::pi / 180, 1e-4);
}

TEST(SickColaTest, AnEmulatorPlaysARecording) {
  const auto scans = emulator::scans_of_cola(stream_of(captured("tim781s.cola-b.txt")), 100);
  ASSERT_EQ(scans.size(), 33U);
  for (const ColaDialect dialect : {ColaDialect::kBinary, ColaDialect::kAscii}) {
    Pair pair({}, {.dialect = dialect, .scan_frequency = 1500, .scans = scans});
    ASSERT_TRUE(pair.run_until_ready());
    EXPECT_EQ(pair.host.scan().channels[0].values, scans[0].channels[0].values);
    pair.line.run(1s);
    EXPECT_EQ(pair.host.scan().channels[1].values,
              scans[(pair.scanner.scans_sent() - 1) % 33].channels[1].values);
  }
}

TEST(SickColaTest, NoiseAndFlippedBitsBreakNothing) {
  std::mt19937 random(1);
  for (int i = 0; i < 40; ++i) {
    Pair pair({}, {.dialect = i % 2 == 0 ? ColaDialect::kBinary : ColaDialect::kAscii});
    pair.line.start();
    for (int j = 0; j < 60; ++j) {
      std::vector<std::byte> noise(random() % 200);
      for (std::byte& byte : noise) byte = static_cast<std::byte>(random() % 8);
      pair.line.disturb(noise);
      pair.line.run(100ms);
      if (pair.host.failure()) pair.line.start_host();
    }
  }
}

}  // namespace sick_cola_test
}  // namespace rack::device
