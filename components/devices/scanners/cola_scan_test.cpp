#include "components/devices/scanners/cola_scan.h"

#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "components/devices/scanners/sick_captured.h"

namespace rack::device {
namespace cola_scan_test {

using namespace std::chrono_literals;

constexpr double kDegree = std::numbers::pi / 180;

// Content of a recording, according to its README.
struct Expected {
  const char* file;
  std::size_t telegrams;
  std::size_t scans;
  std::size_t values;
  std::int32_t start_angle;
  std::uint16_t step;
  std::uint32_t frequency;
  unsigned nearest, farthest;
  std::size_t remission_bits;
  std::uint32_t serial_number;
  std::size_t errors;
  std::size_t fields;    // LFErec
  std::size_t outputs;   // LIDoutputstate
  std::size_t repeated;  // telegram counters
  std::uint32_t started_to_transmitted_min, started_to_transmitted_max;
};
void PrintTo(const Expected& capture, std::ostream* out) { *out << capture.file; }
constexpr std::array<Expected, 4> kExpected = {{
    {"lms111.cola-b.txt", 199, 97, 541, -450000, 5000, 5000, 62, 1841, 0, 18090362, 0, 0, 1, 3,
     3067, 3185},
    {"lms511-a.cola-b.txt", 173, 32, 1141, -50000, 1667, 2500, 282, 2919, 8, 18110550, 18, 3, 4, 0,
     40323, 40978},
    {"lms511.cola-b.txt", 135, 32, 1141, -50000, 1667, 2500, 424, 2915, 8, 18110550, 0, 1, 4, 0,
     40530, 40969},
    {"tim781s.cola-b.txt", 169, 33, 811, -450000, 3333, 1500, 290, 2980, 16, 18480390, 0, 4, 0, 0,
     6208, 7674},
}};

class Counts {
 public:
  void add(const ColaTelegram& telegram) {
    ++telegrams;
    const ColaReader reader(telegram);
    errors += reader.kind() == "sFA" ? 1U : 0U;
    fields += reader.kind() == "sSN" && reader.name() == "LFErec" ? 1U : 0U;
    outputs += reader.kind() == "sSN" && reader.name() == "LIDoutputstate" ? 1U : 0U;
    if (decode_cola_scan(telegram, scan)) add_scan();
  }

  std::size_t telegrams = 0, scans = 0, errors = 0, fields = 0, outputs = 0, repeated = 0;
  unsigned nearest = 65535, farthest = 0;
  std::uint32_t least = 0xFFFFFFFF, most = 0;
  ColaScan scan;
  std::uint16_t counter_before = 0;

 private:
  void add_scan() {
    repeated += scans > 0 && scan.telegram_counter == counter_before ? 1U : 0U;
    counter_before = scan.telegram_counter;
    ++scans;
    for (const std::uint16_t value : scan.channel("DIST1")->values) {
      if (value < 16) continue;
      nearest = std::min<unsigned>(nearest, value);
      farthest = std::max<unsigned>(farthest, value);
    }
    least = std::min(least, scan.transmitted - scan.started);
    most = std::max(most, scan.transmitted - scan.started);
  }
};

class ColaCaptureTest : public testing::TestWithParam<Expected> {};
INSTANTIATE_TEST_SUITE_P(All, ColaCaptureTest, testing::ValuesIn(kExpected));

void expect_counts(const Counts& counts, const Expected& expected) {
  EXPECT_EQ(counts.scans, expected.scans);
  EXPECT_EQ(counts.repeated, expected.repeated);
  EXPECT_EQ(counts.nearest, expected.nearest);
  EXPECT_EQ(counts.farthest, expected.farthest);
  EXPECT_EQ(counts.least, expected.started_to_transmitted_min);
  EXPECT_EQ(counts.most, expected.started_to_transmitted_max);
  const ColaScan& scan = counts.scan;
  EXPECT_EQ(scan.scan_frequency, expected.frequency);
  EXPECT_EQ(scan.serial_number, expected.serial_number);
  EXPECT_TRUE(scan.encoders.empty());
  EXPECT_FALSE(scan.position);
  EXPECT_FALSE(scan.event);
  EXPECT_TRUE(scan.name.empty());
  ASSERT_TRUE(scan.time);
  EXPECT_EQ(scan.time->year, 1970);
  EXPECT_EQ(scan.time->month, 1);

  ASSERT_EQ(scan.channel_count, expected.remission_bits == 0 ? 1U : 2U);
  for (std::size_t i = 0; i < scan.channel_count; ++i) {
    const ColaChannel& channel = scan.channels[i];
    EXPECT_EQ(channel.name(), i == 0 ? "DIST1" : "RSSI1");
    EXPECT_EQ(channel.values.size(), expected.values);
    EXPECT_EQ(channel.start_angle, expected.start_angle);
    EXPECT_EQ(channel.step, expected.step);
    EXPECT_EQ(channel.scale, 1);
    EXPECT_EQ(channel.offset, 0);
    EXPECT_EQ(channel.is_wide, i == 0 || expected.remission_bits == 16);
  }
}

TEST_P(ColaCaptureTest, IsAsItsReadmeStates) {
  Counts counts;
  ColaTelegrams telegrams;
  for (const CaptureRecord& record : captured(GetParam().file)) {
    telegrams.add({.bytes = record.bytes});
    ColaTelegram telegram;
    while (telegrams.next(telegram)) counts.add(telegram);
  }
  EXPECT_EQ(counts.telegrams, GetParam().telegrams);
  EXPECT_EQ(counts.errors, GetParam().errors);
  EXPECT_EQ(counts.fields, GetParam().fields);
  EXPECT_EQ(counts.outputs, GetParam().outputs);
  EXPECT_EQ(telegrams.broken(), 0U);
  expect_counts(counts, GetParam());
}

// Decoded scans are encoded again: in CoLa B the bytes are identical, in CoLa A the content is.
TEST_P(ColaCaptureTest, IsTheSameEncodedAgainAndInColaA) {
  Counts counts;
  for (const CaptureRecord& record : captured(GetParam().file)) {
    ColaTelegrams telegrams;
    telegrams.add({.bytes = record.bytes});
    ColaTelegram telegram;
    ASSERT_TRUE(telegrams.next(telegram));
    ColaScan scan;
    if (!decode_cola_scan(telegram, scan)) continue;
    std::vector<std::byte> body;
    append_cola_scan(body, ColaDialect::kBinary, scan);
    EXPECT_TRUE(std::ranges::equal(body, telegram.body));

    body.clear();
    append_cola_scan(body, ColaDialect::kAscii, scan);
    std::vector<std::byte> text;
    append_cola(text, ColaDialect::kAscii, body);
    ColaTelegrams texts;
    texts.add({.bytes = text});
    ASSERT_TRUE(texts.next(telegram));
    EXPECT_EQ(telegram.dialect, ColaDialect::kAscii);
    counts.add(telegram);
  }
  expect_counts(counts, GetParam());
}

TEST_P(ColaCaptureTest, BecomesScansThatGoClockwise) {
  for (const CaptureRecord& record : captured(GetParam().file)) {
    ColaTelegrams telegrams;
    telegrams.add({.bytes = record.bytes});
    ColaTelegram telegram;
    ASSERT_TRUE(telegrams.next(telegram));
    ColaScan from;
    if (!decode_cola_scan(telegram, from)) continue;
    LadarData scan;
    ASSERT_TRUE(scan_of_cola(from, {}, scan));
    ASSERT_EQ(scan.points.size(), GetParam().values);
    const double half = GetParam().start_angle == -50000 ? 95 : 135;
    EXPECT_NEAR(scan.startAngle, -half * kDegree, 1e-4);
    EXPECT_NEAR(scan.endAngle, half * kDegree, 1e-4);
    EXPECT_EQ(scan.points.front().distance, from.channels[0].values.back());
    EXPECT_EQ(scan.points.back().distance, from.channels[0].values.front());
    const double turn = 100000.0 / GetParam().frequency;
    EXPECT_NEAR(scan.duration, turn * half / 180, 0.5);
    for (std::size_t i = 1; i < scan.points.size(); ++i)
      ASSERT_GT(scan.points[i].angle, scan.points[i - 1].angle);
  }
}

TEST(ColaScanTest, ARealTextOfATim) {
  const auto records = captured("tim55x.cola-a.txt");
  ColaTelegrams telegrams;
  telegrams.add({.bytes = records.front().bytes});
  ColaTelegram telegram;
  ASSERT_TRUE(telegrams.next(telegram));
  EXPECT_EQ(telegram.dialect, ColaDialect::kAscii);
  ColaScan from;
  ASSERT_TRUE(decode_cola_scan(telegram, from));
  EXPECT_EQ(from.serial_number, 0x107375CU);
  EXPECT_EQ(from.telegram_counter, 0xE784);
  EXPECT_EQ(from.scan_counter, 0xE789);
  EXPECT_EQ(from.transmitted - from.started, 0x3D612D1F - 0x3D611E4AU);
  EXPECT_EQ(from.scan_frequency, 1500U);
  EXPECT_EQ(from.measuring_frequency, 54U);
  EXPECT_EQ(from.name, "not defined");
  EXPECT_FALSE(from.time);
  ASSERT_EQ(from.channel_count, 2U);
  EXPECT_FALSE(from.channels[1].is_wide);
  LadarData scan;
  ASSERT_TRUE(scan_of_cola(from, {.reflector_remission = 230}, scan));
  ASSERT_EQ(scan.points.size(), 271U);
  EXPECT_NEAR(scan.startAngle, -135 * kDegree, 1e-5);
  EXPECT_NEAR(scan.endAngle, 135 * kDegree, 1e-5);
  EXPECT_EQ(scan.points[270].distance, 440);
  EXPECT_EQ(scan.points[270].intensity, 170);
  EXPECT_EQ(scan.points[0].distance, 1333);
  EXPECT_EQ(std::ranges::count(scan.points, ladar_point::kInvalid, &LadarPoint::type), 9);
  EXPECT_EQ(std::ranges::count(scan.points, ladar_point::kReflector, &LadarPoint::type), 3);

  // Encoding the scan again gives the same text.
  std::vector<std::byte> body;
  append_cola_scan(body, ColaDialect::kAscii, from);
  EXPECT_TRUE(std::ranges::equal(body, telegram.body));
}

ColaScan full_scan() {
  ColaScan scan{.version = 1, .serial_number = 7, .device_status = {0, 2}, .scan_frequency = 2500};
  scan.layer_angle = -250;
  scan.encoders = {{.position = 123456, .speed = 77}, {.position = 5, .speed = 6}};
  scan.channels.resize(4);
  scan.channel_count = 4;
  const std::array<std::string_view, 4> names = {"DIST1", "DIST2", "RSSI1", "RSSI2"};
  for (std::size_t i = 0; i < 4; ++i) {
    std::ranges::copy(names[i], scan.channels[i].content.begin());
    scan.channels[i].step = 2500;
    scan.channels[i].start_angle = -50000;
    scan.channels[i].is_wide = i < 3;
    scan.channels[i].values = {15, 16, 255, 0, 100};
  }
  scan.channels[0].scale = 2;
  scan.channels[0].offset = 10;
  scan.position = {.place = {1.5F, -2, 0}, .rotation = {0, 0, 3}, .rotation_type = 2};
  scan.name = "at the front";
  scan.comment = "mended";
  scan.time = {.year = 2026, .month = 11, .day = 23, .hour = 8, .microsecond = 999999};
  scan.event = {.type = {'F', 'E', 'C', ' '}, .encoder = 5, .time = 6, .angle = -7};
  return scan;
}

bool decode(ColaDialect dialect, std::span<const std::byte> body, ColaScan& scan) {
  return decode_cola_scan({.dialect = dialect, .body = body}, scan);
}

TEST(ColaScanTest, EverythingThatMayComeWithAScan) {
  ColaScan full = full_scan();
  for (const ColaDialect dialect : {ColaDialect::kBinary, ColaDialect::kAscii}) {
    if (dialect == ColaDialect::kAscii) full.event->type = {'F', 'E', 'C', '1'};
    std::vector<std::byte> body;
    append_cola_scan(body, dialect, full, "sRA LMDscandata");
    ColaScan scan;
    ASSERT_TRUE(decode(dialect, body, scan));
    EXPECT_EQ(scan.encoders.size(), 2U);
    EXPECT_EQ(scan.encoders[0].position, 123456U);
    EXPECT_EQ(scan.encoders[1].speed, 6);
    EXPECT_EQ(scan.layer_angle, -250);
    EXPECT_EQ(scan.status(), 2U);
    ASSERT_EQ(scan.channel_count, 4U);
    EXPECT_EQ(scan.channel("DIST2")->values, full.channels[1].values);
    EXPECT_FALSE(scan.channel("RSSI2")->is_wide);
    EXPECT_EQ(scan.channel("DIST3"), nullptr);
    ASSERT_TRUE(scan.position && scan.time && scan.event);
    EXPECT_EQ(scan.position->place[1], -2);
    EXPECT_EQ(scan.position->rotation_type, 2);
    EXPECT_EQ(scan.name, "at the front");
    EXPECT_EQ(scan.comment, "mended");
    EXPECT_EQ(scan.time->day, 23);
    EXPECT_EQ(scan.time->microsecond, 999999U);
    EXPECT_EQ(scan.event->angle, -7);
    EXPECT_EQ(scan.turn(), 40ms);

    LadarData data;
    ASSERT_TRUE(scan_of_cola(scan, {.max_range = 80000}, data));
    EXPECT_EQ(data.maxRange, 80000);
    EXPECT_EQ(data.points[4].type, ladar_point::kInvalid);  // 15 is a code
    EXPECT_EQ(data.points[3].distance, 42);
    EXPECT_EQ(data.points[2].distance, 520);
  }
}

TEST(ColaScanTest, WhatIsNoScanIsNone) {
  const ColaScan full = full_scan();
  for (const ColaDialect dialect : {ColaDialect::kBinary, ColaDialect::kAscii}) {
    std::vector<std::byte> body;
    append_cola_scan(body, dialect, full);
    ColaScan scan;
    std::size_t good = 0;
    for (std::size_t size = 0; size < body.size(); ++size)
      good += decode(dialect, std::span(body).first(size), scan) ? 1U : 0U;
    // The event at the end is optional; in a text, the last number can be shorter.
    EXPECT_LE(good, dialect == ColaDialect::kBinary ? 1U : 16U);
    std::mt19937 random(1);
    for (int i = 0; i < 20000; ++i) {
      auto broken = body;
      broken[random() % broken.size()] ^= static_cast<std::byte>(1U << random() % 8);
      LadarData data;
      if (decode(dialect, broken, scan)) (void)scan_of_cola(scan, {}, data);
    }
  }
}

TEST(ColaScanTest, TooManyValuesAreThinned) {
  ColaScan from;
  from.channels.resize(1);
  from.channel_count = 1;
  ColaChannel& channel = from.channels[0];
  channel.content = {'D', 'I', 'S', 'T', '1'};
  channel.start_angle = -50000;
  channel.step = 833;
  channel.values.resize(2281);
  for (std::size_t i = 0; i < channel.values.size(); ++i)
    channel.values[i] = static_cast<std::uint16_t>(1000 + i);
  LadarData scan;
  ASSERT_TRUE(scan_of_cola(from, {}, scan));
  ASSERT_EQ(scan.points.size(), 1141U);
  EXPECT_EQ(scan.points[1140].distance, 1000);
  EXPECT_EQ(scan.points[1139].distance, 1002);
  EXPECT_EQ(scan.points[0].distance, 3280);
  EXPECT_NEAR(scan.startAngle, -95 * kDegree, 1e-4);
}

}  // namespace cola_scan_test
}  // namespace rack::device
