#include "components/devices/scanners/cola.h"

#include <random>

#include <gtest/gtest.h>

#include "components/devices/scanners/sick_captured.h"

namespace rack::device {
namespace cola_test {

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

std::vector<std::byte> telegram_of(ColaDialect dialect, std::string_view body) {
  std::vector<std::byte> out;
  append_cola(out, dialect, bytes_of(body));
  return out;
}

std::vector<std::string> take_all(ColaTelegrams& telegrams) {
  std::vector<std::string> bodies;
  ColaTelegram telegram;
  while (telegrams.next(telegram))
    bodies.emplace_back(reinterpret_cast<const char*>(telegram.body.data()), telegram.body.size());
  return bodies;
}

std::vector<std::string> bodies_of(std::span<const std::byte> stream) {
  ColaTelegrams telegrams;
  telegrams.add({.bytes = stream});
  return take_all(telegrams);
}

void append(std::vector<std::byte>& stream, const std::vector<std::byte>& bytes) {
  stream.insert(stream.end(), bytes.begin(), bytes.end());
}

constexpr ColaDialect kAscii = ColaDialect::kAscii;
constexpr ColaDialect kBinary = ColaDialect::kBinary;

TEST(ColaTest, LogsInAsTheRecordedHostDoes) {
  // The first line of a recording.
  const auto recorded = captured("lms111.cola-b.txt").front().bytes;
  std::vector<std::byte> body;
  ColaWriter(kBinary, body, "sMN SetAccessMode")
      .put(std::uint8_t{3})
      .put(std::uint32_t{0xF4724744});
  std::vector<std::byte> telegram;
  append_cola(telegram, kBinary, body);
  EXPECT_EQ(telegram, recorded);

  body.clear();
  ColaWriter(kAscii, body, "sMN SetAccessMode").put(std::uint8_t{3}).put(std::uint32_t{0xF4724744});
  EXPECT_EQ(body, bytes_of("sMN SetAccessMode 3 F4724744"));
}

TEST(ColaTest, EverySplitGivesTheSameTelegrams) {
  std::vector<std::byte> stream = bytes_of("\x02\x02noise\x03");
  append(stream, telegram_of(kBinary, "sRA One \x02\x02\x02\x02 two"));
  append(stream, telegram_of(kAscii, "sRA Two 5 +3"));
  append(stream, telegram_of(kBinary, "sFA\x01"));
  append(stream, telegram_of(kAscii, "sFA 3"));
  const std::vector<std::string> wanted = {"sRA One \x02\x02\x02\x02 two", "sRA Two 5 +3",
                                           "sFA\x01", "sFA 3"};
  for (std::size_t cut = 0; cut <= stream.size(); ++cut) {
    ColaTelegrams telegrams;
    std::vector<std::string> found;
    for (const auto piece : {std::span(stream).first(cut), std::span(stream).subspan(cut)}) {
      telegrams.add({.bytes = piece});
      for (const std::string& body : take_all(telegrams)) found.push_back(body);
    }
    EXPECT_EQ(found, wanted) << cut;
  }
}

TEST(ColaTest, ATextThatWasCutOffEndsAtTheNextStart) {
  std::vector<std::byte> stream = telegram_of(kAscii, "sSN Cut 1 2 3");
  stream.resize(8);
  append(stream, telegram_of(kAscii, "sSN Whole 1"));
  EXPECT_EQ(bodies_of(stream), std::vector<std::string>{"sSN Whole 1"});
}

TEST(ColaTest, AFlippedBitCostsOneTelegram) {
  std::mt19937 random(1);
  std::vector<std::byte> noise(std::size_t{1} << 15);
  for (std::byte& byte : noise) byte = static_cast<std::byte>(random() | 0x80);
  for (const ColaDialect dialect : {kBinary, kAscii}) {
    const auto one = telegram_of(dialect, "sRA Number 1234 ABCD");
    for (std::size_t i = 0; i < one.size() * 8; ++i) {
      auto stream = one;
      stream[i / 8] ^= static_cast<std::byte>(1 << i % 8);
      // CoLa A has no check byte: a changed letter or a premature end is not detected.
      const std::byte became = stream[i / 8];
      const bool is_text =
          dialect == kAscii && (became >= std::byte{' '} || became == std::byte{3});
      append(stream, one);
      append(stream, one);
      // Enough noise to complete a telegram with a corrupted length.
      append(stream, noise);
      const std::size_t found = bodies_of(stream).size();
      EXPECT_GE(found, 2U) << i;
      EXPECT_LE(found, is_text ? 3U : 2U) << i;
    }
  }
}

TEST(ColaTest, JoinsARecordingAnywhere) {
  const auto records = captured("lms511-a.cola-b.txt");
  const auto stream = stream_of(records);
  std::size_t begin = 0;
  for (std::size_t i = 0; i < 130; ++i) begin += records[i].bytes.size();
  for (std::size_t in = 0; in < records[130].bytes.size() + 4000; in += 7) {
    std::size_t rest = records.size();
    std::size_t end = 0;
    for (const CaptureRecord& record : records) {
      if (end >= begin + in) break;
      end += record.bytes.size();
      --rest;
    }
    ColaTelegrams telegrams;
    std::size_t found = 0;
    auto to_come = std::span(stream).subspan(begin + in);
    while (!to_come.empty()) {
      const auto piece = to_come.first(std::min<std::size_t>(1448, to_come.size()));
      telegrams.add({.bytes = piece});
      to_come = to_come.subspan(piece.size());
      found += take_all(telegrams).size();
    }
    EXPECT_EQ(found, rest) << in;
  }
}

TEST(ColaTest, ReadsWhatItWrites) {
  for (const ColaDialect dialect : {kBinary, kAscii}) {
    std::vector<std::byte> body;
    ColaWriter(dialect, body, "sWN All")
        .put(std::uint8_t{0xFE})
        .put(std::int16_t{-2})
        .put(std::int32_t{-450000})
        .put(std::uint32_t{0xFFFFFFFF})
        .put_float(2.5F)
        .put_text("DIST1")
        .put_string("not defined")
        .put_float(0);
    ColaReader reader(dialect, body);
    EXPECT_EQ(reader.kind(), "sWN");
    EXPECT_EQ(reader.name(), "All");
    EXPECT_EQ(reader.take<std::uint8_t>(), 0xFE);
    EXPECT_EQ(reader.take<std::int16_t>(), -2);
    EXPECT_EQ(reader.take<std::int32_t>(), -450000);
    EXPECT_EQ(reader.take<std::uint32_t>(), 0xFFFFFFFF);
    EXPECT_EQ(reader.take_float(), 2.5F);
    EXPECT_EQ(reader.take_text(5), "DIST1");
    EXPECT_EQ(reader.take_string(), "not defined");
    EXPECT_EQ(reader.take_float(), 0);
    EXPECT_TRUE(reader.at_end());
    EXPECT_TRUE(reader.good());
    EXPECT_EQ(reader.take<std::uint8_t>(), 0);
    EXPECT_FALSE(reader.good());
  }
}

TEST(ColaTest, NumbersOfATextAreHexadecimalOrSigned) {
  const auto body = bytes_of("sSN Numbers 1F +31 -5 123456789 G -");
  ColaReader reader(kAscii, body);
  EXPECT_EQ(reader.take<std::uint16_t>(), 31);
  EXPECT_EQ(reader.take<std::uint16_t>(), 31);
  EXPECT_EQ(reader.take<std::int32_t>(), -5);
  EXPECT_TRUE(reader.good());
  EXPECT_EQ(reader.take<std::uint32_t>(), 0U);
  EXPECT_FALSE(reader.good());
  for (const std::string_view wrong : {"sSN N G", "sSN N -", "sSN N +", "sSN N 12g4", "sSN N  1"}) {
    const auto bytes = bytes_of(wrong);
    ColaReader one(kAscii, bytes);
    one.take<std::uint32_t>();
    EXPECT_FALSE(one.good()) << wrong;
  }
}

TEST(ColaTest, ErrorsHaveNumbersAndTexts) {
  for (const CaptureRecord& record : captured("lms511-a.cola-b.txt")) {
    ColaTelegrams telegrams;
    telegrams.add({.bytes = record.bytes});
    ColaTelegram telegram;
    ASSERT_TRUE(telegrams.next(telegram));
    ColaReader reader(telegram);
    if (reader.kind() != "sFA") continue;
    EXPECT_EQ(reader.take<std::uint16_t>(), 3);
  }
  const auto text = bytes_of("sFA 3");
  ColaReader reader(kAscii, text);
  EXPECT_EQ(reader.take<std::uint16_t>(), 3);
  EXPECT_EQ(cola_error_text(3), "unknown variable");
  EXPECT_EQ(cola_error_text(26), "");
}

TEST(ColaTest, NoiseBreaksNothing) {
  std::mt19937 random(1);
  ColaTelegrams telegrams;
  constexpr std::string_view kLetters = "\x02\x02\x02\x03s \x00\x01RANF019A";
  for (int i = 0; i < 20000; ++i) {
    std::vector<std::byte> noise(random() % 100);
    for (std::byte& byte : noise)
      byte = static_cast<std::byte>(kLetters[random() % kLetters.size()]);
    telegrams.add({.bytes = noise});
    ColaTelegram telegram;
    while (telegrams.next(telegram)) {
      ColaReader reader(telegram);
      std::vector<std::uint16_t> values;
      reader.take_values(reader.take<std::uint16_t>() % 50, random() % 2 == 0, values);
      reader.take_string();
      reader.take_text(5);
    }
  }
}

}  // namespace cola_test
}  // namespace rack::device
