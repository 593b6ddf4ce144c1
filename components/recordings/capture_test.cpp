#include "rack/devices/capture.h"

#include <gtest/gtest.h>

#include "base/text.h"

namespace rack::device {
namespace capture_test {

using namespace std::chrono_literals;

std::vector<std::byte> bytes(std::string_view hex) { return *tims::base::parse_hex(hex); }

TEST(CaptureTest, ARecordIsReadAsItWasWritten) {
  std::string text;
  append_record(text, 2s + 1ns, Direction::kSent, 0, bytes("0200FF"));
  EXPECT_EQ(text, "2.000000001 > 0200FF\n");
  CaptureRecord record;
  ASSERT_TRUE(parse_record("2.000000001 > 0200FF", record).value());
  EXPECT_EQ(record.time, 2s + 1ns);
  EXPECT_EQ(record.direction, Direction::kSent);
  EXPECT_EQ(record.bytes, bytes("0200FF"));

  text.clear();
  append_record(text, 0s, Direction::kReceived, 0x80000123, {});
  ASSERT_TRUE(parse_record(std::string_view(text).substr(0, text.size() - 1), record).value());
  EXPECT_EQ(record.id, 0x80000123U);
  EXPECT_TRUE(record.bytes.empty());

  text.clear();
  append_event(text, 1ms, "gone:\nagain");
  EXPECT_EQ(text, "0.001000000 ! gone:?again\n");
  ASSERT_TRUE(parse_record("0.001000000 ! the device is gone", record).value());
  EXPECT_EQ(record.event, "the device is gone");
}

TEST(CaptureTest, WhatADriverDidIsReadAsItWasWritten) {
  std::string text;
  append_record(text, 2s, Direction::kTime, 0, {});
  append_record(text, 1s, Direction::kMade, 42, bytes("9F3C"));
  EXPECT_EQ(text, "2.000000000 ~ \n1.000000000 = 0000002A#9F3C\n");
  CaptureRecord record;
  ASSERT_TRUE(parse_record("2.000000000 ~ ", record).value());
  EXPECT_EQ(record.direction, Direction::kTime);
  ASSERT_TRUE(parse_record("0.0 *", record).value());
  EXPECT_EQ(record.direction, Direction::kStarted);
  ASSERT_TRUE(parse_record("1.000000000 = 0000002A#9F3C", record).value());
  EXPECT_EQ(record.direction, Direction::kMade);
  EXPECT_EQ(record.id, 42U);
  EXPECT_EQ(record.bytes, bytes("9F3C"));
}

TEST(CaptureTest, LinesWithoutADirectionWereReceived) {
  CaptureRecord record;
  ASSERT_TRUE(parse_record("0.204711 02020202\r", record).value());
  EXPECT_EQ(record.direction, Direction::kReceived);
  EXPECT_EQ(record.time, 204711us);
  EXPECT_EQ(record.bytes, bytes("02020202"));
  EXPECT_FALSE(parse_record("", record).value());
  EXPECT_FALSE(parse_record("# a comment", record).value());
}

TEST(CaptureTest, LinesOfCandump) {
  CaptureRecord record;
  ASSERT_TRUE(parse_record("(1436509052.249713) vcan0 244#2A366C2BBA", record).value());
  EXPECT_EQ(record.time, 1436509052s + 249713us);
  EXPECT_EQ(record.id, 0x244U);
  EXPECT_EQ(record.bytes, bytes("2A366C2BBA"));
  ASSERT_TRUE(parse_record("(0.5) can0 18DAF110#", record).value());
  EXPECT_EQ(record.id, 0x98DAF110);
  ASSERT_TRUE(parse_record("(0.5) can0 123#R", record).value());
  EXPECT_EQ(record.id, 0x40000123U);
}

TEST(CaptureTest, CandumpLogsHaveOtherFramesBusesAndDirections) {
  CaptureRecord record;
  ASSERT_TRUE(parse_record("(0.5) can1 181##1AABB", record).value());
  EXPECT_EQ(record.frame, FrameKind::kFd);
  EXPECT_EQ(record.bytes, bytes("AABB"));
  EXPECT_EQ(record.bus, "can1");
  ASSERT_TRUE(parse_record("(0.5) can0 181##0" + std::string(128, 'A'), record).value());
  EXPECT_FALSE(parse_record("(0.5) can0 181##0" + std::string(130, 'A'), record));
  EXPECT_FALSE(parse_record("(0.5) can0 181##", record));
  ASSERT_TRUE(parse_record("(0.5) can0 20000004#0008000000000000 R", record).value());
  EXPECT_EQ(record.frame, FrameKind::kError);
  EXPECT_EQ(record.direction, Direction::kReceived);
  EXPECT_TRUE(parse_record("(0.5) " + std::string(15, 'c') + " 181#", record));
  EXPECT_FALSE(parse_record("(0.5) " + std::string(16, 'c') + " 181#", record));
  ASSERT_TRUE(parse_record("(0.5) can0 601#40 T", record).value());
  EXPECT_EQ(record.direction, Direction::kSent);
  EXPECT_EQ(record.frame, FrameKind::kData);
  ASSERT_TRUE(parse_record("(0.5) can0 701#R8", record).value());
  EXPECT_EQ(record.id, 0x40000701U);
}

TEST(CaptureTest, WhatIsNoLineIsRefused) {
  CaptureRecord record;
  for (const char* line :
       {"hello", "-1 < 00", "1.2 < 0", "1.2 < 0g", "1.2 < 00 00", "1.x < 00", "1 < 1G#00",
        "99999999999999999999 < 00", "(1.0 can0 123#00", "(1.0) can0", "(1.0) can0 12300",
        "(1.0) can0 123#000102030405060708", "<", "(", "1.2 < #00"})
    EXPECT_FALSE(parse_record(line, record)) << line;
}

TEST(CaptureTest, TheBeginningDeterminesTheFormat) {
  const auto format = [](std::string_view text) {
    return format_of(std::as_bytes(std::span(text)));
  };
  EXPECT_EQ(format(capture_header("can:can0", "today") + "anything"), RecordingFormat::kCapture);
  EXPECT_EQ(format("(1.0) can0 123#00\n"), RecordingFormat::kCapture);
  EXPECT_EQ(format("0.2 0202\n0.3 03\n"), RecordingFormat::kCapture);
  EXPECT_EQ(format("# from somebody else\n\n0.2 0202\n"), RecordingFormat::kCapture);
  EXPECT_EQ(format("0.2 0202020"), RecordingFormat::kCapture);  // a long line, truncated here
  EXPECT_EQ(format("\xEF\xBB\xBF# rack capture 1 x\n0.2 02\n"), RecordingFormat::kCapture);
  EXPECT_EQ(format("0202FF\n0.3 < 03\n0.4 < 04\n"), RecordingFormat::kCapture)
      << "the end of a recording";
  EXPECT_EQ(format("0202FF\nno\n0.3 < 03\n0.4 < 04\n"), RecordingFormat::kRaw);
  EXPECT_EQ(format("  can0  181   [8]  00 00\n"), RecordingFormat::kCandumpView);
  EXPECT_EQ(format("(17.000000)  can0  20000004   [8]  00\n"), RecordingFormat::kCandumpView);
  EXPECT_EQ(format("(17.000000)  can0  RX - -  181\n"), RecordingFormat::kRaw);
  EXPECT_EQ(format("0280D602 B0690100\n"), RecordingFormat::kHexText);
  EXPECT_EQ(format("no recording at all\n"), RecordingFormat::kRaw);
  EXPECT_EQ(format("# nothing but text\n"), RecordingFormat::kRaw);
  EXPECT_EQ(format("$GPGGA,1\n"), RecordingFormat::kRaw);
  EXPECT_EQ(format("\xD4\xC3\xB2\xA1 and more"), RecordingFormat::kPcap);
  EXPECT_EQ(format("\x0A\x0D\x0D\x0A and more"), RecordingFormat::kPcap);
  EXPECT_EQ(format(""), RecordingFormat::kRaw);
}

TEST(Capture, HowLongTheBytesTookComesBack) {
  using namespace std::chrono_literals;
  std::string line;
  append_record(line, 10ms, Direction::kReceived, 0, std::vector<std::byte>(1, std::byte{6}),
                320us);
  EXPECT_EQ(line, "0.010000000-0.000320000 < 06\n");
  line.pop_back();
  CaptureRecord record;
  ASSERT_TRUE(parse_record(line, record));
  EXPECT_EQ(record.time, 10ms);
  EXPECT_EQ(record.took, 320us);
  ASSERT_TRUE(parse_record("0.010000000 < 06", record));
  EXPECT_EQ(record.took, 0us);
  EXPECT_FALSE(parse_record("0.010000000- < 06", record));
  EXPECT_FALSE(parse_record("0.01-x < 06", record));
}

}  // namespace capture_test
}  // namespace rack::device
