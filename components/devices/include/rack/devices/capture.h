// Captures: the data received from and sent to a device as lines of text, so that a recording from
// the field can be copied into a test.
//
//   # rack capture 1 serial:/dev/ttyUSB0?baud=500000 2026-11-23T09:30:00Z
//   0.000000000 > 0200020030013118
//   0.004211300 < 06
//   0.010000000-0.000320000 < 020080060014     (the first bit arrived 320 us before the last)
//   2.100000000 ! the device is gone
//   3.512345678 < 181#3701000000000000          (a CAN frame, or a datagram: id#bytes)
//
// Drivers add records from which a replay can reproduce and compare their data (replay.h):
//
//   0.000000000 *                               (the device was opened and the dialogue started)
//   0.020113000 ~                               (the dialogue was called with this time)
//   0.009680000 = 0000002A#9F3C55D210B7E604     (a data set: time of measurement, number of records
//                                               read since *, checksum)
//
// Format: seconds since the start of the recording (optionally the duration of the transmission),
// direction, bytes in hex. Records without a direction were received. Lines of candump
// ("(1700000000.123456) can0 181#3701", optionally with R or T for received and sent) can be read
// as well. Empty lines and lines that begin with # are skipped.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tims/result.h"
#include "tims/time.h"

#pragma GCC visibility push(default)  // exported by librack-devices.so
namespace rack::device {

using tims::Duration;
using tims::Result;

enum class Direction : char {
  kReceived = '<',
  kSent = '>',
  kEvent = '!',
  kStarted = '*',
  kTime = '~',
  kMade = '='
};

// Frames other than kData exist in candump logs only; drivers cannot use them.
enum class FrameKind : std::uint8_t { kData, kFd, kError };

struct CaptureRecord {
  Duration time{};  // since the start of the recording; in candump logs since their epoch
  Direction direction = Direction::kReceived;
  std::uint32_t id = 0;
  Duration took{};  // from the first bit to the last
  std::vector<std::byte> bytes{};
  std::string event{};
  FrameKind frame = FrameKind::kData;
  std::string bus{};  // candump logs: the interface
};

std::string capture_header(std::string_view device, std::string_view date);

// Appends one line with its line end. Does not allocate if the capacity of `text` suffices.
void append_record(std::string& text, Duration time, Direction direction, std::uint32_t id,
                   std::span<const std::byte> bytes, Duration took = {});
void append_event(std::string& text, Duration time, std::string_view event);

// kCandumpView, kHexText: texts that are mistaken for recordings: what candump displays, and hex
// digits.
enum class RecordingFormat : std::uint8_t { kRaw, kCapture, kPcap, kCandumpView, kHexText };
// Detects the format from the beginning of a file: some hundred bytes, or some lines if the first
// one may be incomplete.
RecordingFormat format_of(std::span<const std::byte> beginning);

// Parses a line without its line end into `record`, whose memory is reused. Returns false if the
// line has no record (empty, a comment). kMalformed: the line is not part of a recording.
Result<bool> parse_record(std::string_view line, CaptureRecord& record);

}  // namespace rack::device

#pragma GCC visibility pop
