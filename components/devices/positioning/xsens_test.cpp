#include "components/devices/positioning/xsens.h"

#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "components/devices/core/test_bytes.h"

namespace rack::device {
namespace xsens_test {

using namespace std::chrono_literals;

constexpr double kDegree = std::numbers::pi / 180;

// Complete messages published by others, with the checksums of the device.
constexpr std::string_view kAccelerationAndRate =
    "FAFF3631 1020 02 DFC5 1060 04 00459DA0 4020 0C BEDC9AFA 3F549F37 411CBB70"
    "8020 0C BBAA5C80 3B8C5501 BB813300 E020 04 00000081 45";
constexpr std::string_view kEuler = "FAFF3614 1020 02 0009 2030 0C BFBC67E0 3EDFAE81 40A3A9DF A7";
constexpr std::string_view kQuaternion =
    "FAFF3626 2010 10 3EFC2342 3F00E028 BF018FA7 3EFEEEB1 1060 04 000AF84C E020 04 00000002"
    "1020 02 1BC5 D4";
constexpr std::string_view kAll =
    "FAFF364E 1060 04 025335CB 2010 10 3F7FFA66 BB4034B8 3C49962D 3B5A1F82"
    "8020 0C 39FF9101 BAECDD81 BA865380 4020 0C BE64DB99 BCE7FF83 411DC2CF"
    "C020 0C BE904880 3F673204 BF548904 E020 04 00000003 C9";
// Data of an MTi-300, without frame, with their decoding by the manufacturer's program.
constexpr std::string_view kMti300 =
    "1020 02 A655 1060 04 0057472E 2010 10 3F7F7DC4 BC10107D 3BA15770 BD7EC656"
    "4020 0C BDA21AF8 BE2A8E96 411D27A2 4010 0C B94FC800 B9DA2400 3CC92880"
    "4030 0C 3C02C89C 3C35F6C8 3CDB0C00 8020 0C BBB17D81 BB963200 3C01E841"
    "8030 10 3F800000 B6E33001 B6C04000 37264800 C020 0C BE999C24 3FB61B56 3F166AEB"
    "3010 04 000186DE E020 04 00400003";

XsensSample sample_of(std::string_view hex) {
  XsensMessages messages;
  const auto bytes = bytes_of_hex(hex);
  messages.add({.bytes = bytes});
  XsensMessage message;
  XsensSample sample;
  EXPECT_TRUE(messages.next(message)) << hex;
  EXPECT_TRUE(decode_xsens(message, sample)) << hex;
  return sample;
}

TEST(XsensTest, MessagesOfOthers) {
  auto sample = sample_of(kAccelerationAndRate);
  EXPECT_NEAR(sample.acceleration->z, 9.7957611, 1e-6);
  EXPECT_NEAR(sample.rate->y, 0.0042826, 1e-6);
  EXPECT_EQ(sample.counter, 0x459DA0U);
  EXPECT_FALSE(sample.euler || sample.orientation);
  sample = sample_of(kEuler);
  EXPECT_NEAR(sample.euler->x, -1.47191 * kDegree, 1e-6);
  EXPECT_NEAR(sample.euler->z, 5.11448 * kDegree, 1e-6);
  sample = sample_of(kQuaternion);
  EXPECT_NEAR(sample.orientation->w, 0.492457, 1e-6);
  EXPECT_TRUE(sample_of(kAll).orientation);
}

TEST(XsensTest, AnMti300) {
  std::vector<std::byte> bytes;
  append_xsens(bytes, xsens::kData2, bytes_of_hex(kMti300));
  XsensMessages messages;
  messages.add({.bytes = bytes});
  XsensMessage message;
  ASSERT_TRUE(messages.next(message));
  XsensSample sample;
  ASSERT_TRUE(decode_xsens(message, sample));
  EXPECT_EQ(sample.counter, 5719854U);
  EXPECT_NEAR(sample.orientation->w, 0.99801278, 1e-7);
  EXPECT_NEAR(sample.orientation->z, -0.06220087, 1e-7);
  EXPECT_NEAR(sample.acceleration->z, 9.82217598, 1e-6);
  EXPECT_NEAR(sample.rate->x, -0.00541657, 1e-7);
  EXPECT_EQ(sample.frame, xsens::kEastNorthUp);
}

TEST(XsensTest, QuestionsOfOthers) {
  const auto message = [](std::uint8_t number, std::string_view data) {
    std::vector<std::byte> bytes;
    append_xsens(bytes, number, bytes_of_hex(data));
    return bytes;
  };
  EXPECT_EQ(message(xsens::kToConfiguration, ""), bytes_of_hex("FAFF3000D1"));
  EXPECT_EQ(message(xsens::kToMeasurement, ""), bytes_of_hex("FAFF1000F1"));
  EXPECT_EQ(message(0x8E, "0000"), bytes_of_hex("FAFF8E02000071"));
  EXPECT_EQ(message(xsens::kSetOutput,
                    "1020FFFF1060FFFF201001904020019040100190403001908020019080300190C02000640810"
                    "000A30100032E020FFFF")
                .back(),
            std::byte{0x99});
}

// --- axes

XsensSample level(double yaw_degrees) {
  XsensSample sample;
  sample.acceleration = {0.1, 0.2, 9.81};
  sample.rate = {0.01, 0.02, 0.03};
  sample.euler = {0, 0, yaw_degrees * kDegree};
  return sample;
}

TEST(XsensTest, AsTheOriginalHasIt) {
  GyroData data;
  ASSERT_TRUE(to_gyro(level(30), XsensMounting::kUnchanged, data));
  EXPECT_FLOAT_EQ(data.aZ, -9810);
  EXPECT_FLOAT_EQ(data.wYaw, 0.03F);  // rad/s, unchanged
  EXPECT_NEAR(data.yaw, 30 * kDegree, 1e-6);
}

TEST(XsensTest, LabelUpTheRobotsAxesAreClockwise) {
  GyroData data;
  ASSERT_TRUE(to_gyro(level(30), XsensMounting::kLabelUp, data));  // to the west
  EXPECT_NEAR(data.yaw, -30 * kDegree, 1e-6);
  EXPECT_NEAR(data.roll, 0, 1e-6);
  EXPECT_NEAR(data.pitch, 0, 1e-6);
  EXPECT_FLOAT_EQ(data.aX, -100);
  EXPECT_FLOAT_EQ(data.aY, 200);
  EXPECT_FLOAT_EQ(data.aZ, 9810);
  EXPECT_FLOAT_EQ(data.wYaw, -0.03F);
  auto sample = level(90);  // from east to north: 0 for a robot
  sample.frame = xsens::kEastNorthUp;
  ASSERT_TRUE(to_gyro(sample, XsensMounting::kLabelUp, data));
  EXPECT_NEAR(data.yaw, 0, 1e-6);
  sample = level(0);
  sample.euler->y = 10 * kDegree;  // nose down about the axis to the left
  ASSERT_TRUE(to_gyro(sample, XsensMounting::kLabelUp, data));
  EXPECT_NEAR(data.pitch, -10 * kDegree, 1e-6);
}

TEST(XsensTest, LabelDownTheDevicesAxesAreTheRobots) {
  GyroData data;
  auto sample = level(-50);
  sample.euler->x = 180 * kDegree;  // z up is below
  ASSERT_TRUE(to_gyro(sample, XsensMounting::kLabelDown, data));
  EXPECT_NEAR(data.yaw, 50 * kDegree, 1e-6);
  EXPECT_NEAR(data.roll, 0, 1e-6);
  sample = level(50);
  sample.frame = xsens::kNorthEastDown;
  ASSERT_TRUE(to_gyro(sample, XsensMounting::kLabelDown, data));
  EXPECT_NEAR(data.yaw, 50 * kDegree, 1e-6);
}

TEST(XsensTest, WhatIsMissingIsNoData) {
  GyroData data;
  auto sample = level(0);
  sample.rate.reset();
  EXPECT_FALSE(to_gyro(sample, XsensMounting::kUnchanged, data));
}

// --- streams

TEST(XsensTest, EverySplitAndEveryFlippedBit) {
  const auto frame = bytes_of_hex(kAll);
  auto stream = bytes_of_hex("00FA01FF");
  for (const auto& one : {bytes_of_hex(kEuler), frame, bytes_of_hex(kQuaternion)})
    stream.insert(stream.end(), one.begin(), one.end());
  for (std::size_t cut = 0; cut <= stream.size(); ++cut) {
    XsensMessages messages;
    int found = 0;
    for (const auto piece : {std::span(stream).first(cut), std::span(stream).subspan(cut)}) {
      messages.add({.bytes = piece});
      XsensMessage message;
      while (messages.next(message)) ++found;
    }
    EXPECT_EQ(found, 3) << cut;
  }
  for (std::size_t i = 0; i < frame.size() * 8; ++i) {
    auto flipped = frame;
    flipped[i / 8] ^= static_cast<std::byte>(1 << i % 8);
    for (int again = 0; again < 30; ++again)
      flipped.insert(flipped.end(), frame.begin(), frame.end());
    XsensMessages messages;
    messages.add({.bytes = flipped});
    XsensMessage message;
    int found = 0;
    while (messages.next(message)) ++found;
    EXPECT_GE(found, 27) << i;
    EXPECT_LE(found, 30) << i;
  }
}

TEST(XsensTest, ALongMessageHasTwoBytesOfLength) {
  const std::vector<std::byte> data(300, std::byte{1});
  std::vector<std::byte> bytes;
  append_xsens(bytes, 0x91, data);
  EXPECT_EQ(bytes.size(), 307U);
  XsensMessages messages;
  messages.add({.bytes = bytes});
  XsensMessage message;
  ASSERT_TRUE(messages.next(message));
  EXPECT_EQ(message.data.size(), 300U);
}

TEST(XsensTest, NoiseBreaksNothing) {
  std::mt19937 random(1);
  ReceivedOutput out;
  Xsens dialogue({});
  Time now{1000s};
  dialogue.start(now, out);
  constexpr std::array<unsigned, 6> kLikely = {0xFA, 0xFF, 0x36, 0x32, 0x31, 0x04};
  for (int i = 0; i < 20000; ++i) {
    std::vector<std::byte> noise(random() % 60);
    for (std::byte& byte : noise)
      byte =
          static_cast<std::byte>(random() % 2 == 0 ? kLikely[random() % kLikely.size()] : random());
    now += 10ms;
    dialogue.on_arrival({.bytes = noise, .first = now, .last = now}, out);
    if (dialogue.next_timeout() <= now) dialogue.on_timeout(now, out);
    if (dialogue.failure()) dialogue.start(now, out);
  }
}

}  // namespace xsens_test
}  // namespace rack::device
