#include "devices/protocol/lms200.h"

#include <deque>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace rack::device {
namespace {

using namespace std::chrono_literals;

std::vector<std::byte> bytes_of(std::initializer_list<int> values) {
  std::vector<std::byte> bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

std::vector<std::byte> measurement(std::size_t values, unsigned flags, int distance) {
  const auto word = static_cast<unsigned>(values) | flags;
  std::vector<std::byte> body =
      bytes_of({0xB0, static_cast<int>(word & 0xFF), static_cast<int>(word >> 8)});
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
    // What looks like the beginning of a long telegram is found out when enough has come.
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

// --- The dialogue, against a scanner that is as the manual says

class Scanner {
 public:
  explicit Scanner(std::uint32_t baud) : baud_(baud) {}

  std::uint32_t baud() const { return baud_; }
  bool measures() const { return measures_; }
  std::vector<std::byte> hear(std::span<const std::byte> bytes, std::uint32_t host_baud) {
    if (host_baud != baud_) return {};
    telegrams_.add({.bytes = bytes});
    std::vector<std::byte> answer;
    Lms200Telegram got;
    while (telegrams_.next(got) == Lms200Telegrams::What::kTelegram) reply(got.body, answer);
    return answer;
  }

 private:
  void reply(std::span<const std::byte> body, std::vector<std::byte>& answer) {
    answer.push_back(std::byte{0x06});
    const auto mode = std::to_integer<int>(body[1]);
    append_lms200(answer, bytes_of({0xA0, 0x00, 0x10}), 0x80);
    if (mode == 0x48) next_baud_ = 500000;
    if (mode == 0x40) next_baud_ = 38400;
    if (mode == 0x42) next_baud_ = 9600;
    measures_ = mode == 0x24 || mode == 0x2A;
    if (next_baud_ != 0) baud_ = std::exchange(next_baud_, 0);
  }

  std::uint32_t baud_;
  std::uint32_t next_baud_ = 0;
  bool measures_ = false;
  Lms200Telegrams telegrams_;
};

// Both, and the line between them, on a clock of their own.
class Lms200DialogueTest : public testing::Test, public Output {
 public:
  void send(std::span<const std::byte> bytes, std::uint32_t) override {
    ++sent_;
    const auto answer = scanner_.hear(bytes, baud_);
    if (lose_ > 0)
      --lose_;
    else if (!answer.empty())
      answers_.push_back(answer);
  }
  void set_baud(std::uint32_t baud) override { baud_ = baud; }

  void run(Lms200& dialogue, Duration how_long = 30s) {
    dialogue.start(now_, *this);
    const Time end = now_ + how_long;
    while (!dialogue.is_ready() && !dialogue.failure() && now_ < end) {
      if (!answers_.empty()) {
        now_ += 10ms;
        const auto answer = answers_.front();
        answers_.pop_front();
        dialogue.on_arrival({.bytes = answer, .first = now_, .last = now_}, *this);
      } else {
        now_ = std::min(dialogue.next_timeout(), end);
        dialogue.on_timeout(now_, *this);
      }
    }
  }

 protected:
  Scanner scanner_{9600};
  std::uint32_t baud_ = 0;
  int sent_ = 0;
  int lose_ = 0;
  std::deque<std::vector<std::byte>> answers_;
  Time now_{1000s};
};

TEST_F(Lms200DialogueTest, BringsAScannerToItsRateAndStartsIt) {
  for (const std::uint32_t rate_before : {9600U, 500000U}) {
    scanner_ = Scanner(rate_before);
    Lms200 dialogue({.baud = 500000});
    run(dialogue);
    EXPECT_TRUE(dialogue.is_ready());
    EXPECT_EQ(scanner_.baud(), 500000U);
    EXPECT_EQ(baud_, 500000U);
    EXPECT_TRUE(scanner_.measures());
  }
}

TEST_F(Lms200DialogueTest, ALostAnswerIsAskedForAgain) {
  for (int lost = 1; lost <= 2; ++lost) {
    scanner_ = Scanner(9600);
    lose_ = lost;
    Lms200 dialogue({.baud = 9600});
    run(dialogue);
    EXPECT_TRUE(dialogue.is_ready()) << lost;
  }
}

TEST_F(Lms200DialogueTest, SaysThatNobodyAnswers) {
  scanner_ = Scanner(19200);
  Lms200 dialogue({.baud = 38400});
  run(dialogue);
  ASSERT_TRUE(dialogue.failure());
  EXPECT_THAT(dialogue.failure()->detail(), testing::HasSubstr("neither at 9600 nor at 38400"));
  EXPECT_EQ(sent_, 6);
}

TEST_F(Lms200DialogueTest, AScanIsOfTheTimeWhenTheMirrorWasInItsMiddle) {
  Lms200 dialogue({.only_listen = true});
  dialogue.start(now_, *this);
  EXPECT_TRUE(dialogue.is_ready());
  const auto bytes = telegram(measurement(181, kMillimetres, 1000));
  dialogue.on_arrival({.bytes = bytes, .first = now_ - 7440us, .last = now_}, *this);
  LadarData scan;
  Time recorded;
  ASSERT_TRUE(dialogue.take(scan, recorded));
  EXPECT_EQ(recorded, now_ - 7440us - 3ms);
  EXPECT_FALSE(dialogue.take(scan, recorded));
  EXPECT_EQ(sent_, 0);
}

TEST_F(Lms200DialogueTest, NoiseBreaksNothing) {
  std::mt19937 random(1);
  Lms200 dialogue({.baud = 500000});
  dialogue.start(now_, *this);
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::byte> noise(random() % 200);
    for (std::byte& byte : noise) byte = static_cast<std::byte>(random() % 8);
    now_ += 10ms;
    dialogue.on_arrival({.bytes = noise, .first = now_, .last = now_}, *this);
    if (dialogue.next_timeout() <= now_) dialogue.on_timeout(now_, *this);
    if (dialogue.failure()) dialogue.start(now_, *this);
  }
}

}  // namespace
}  // namespace rack::device
