// What came from a device and went to it, as lines of text: a field bug becomes a test by a copy.
//
//   # rack capture 1 serial:/dev/ttyUSB0?baud=500000 2026-11-23T09:30:00Z
//   0.000000000 > 0200020030013118
//   0.004211300 < 06
//   0.010000000-0.000320000 < 020080060014     (its first bit came 320 us before its last)
//   2.100000000 ! the device is gone
//   3.512345678 < 181#3701000000000000          (a CAN frame, or a datagram: id#bytes)
//
// and what drivers add, for the same data to be made of it again (replay.h):
//
//   0.000000000 *                               (the device was opened, and the dialogue started)
//   0.020113000 ~                               (the dialogue was told the time)
//   0.009680000 = 0000002A#9F3C55D210B7E604     (data were made: when they were measured, records
//                                               read since *, a checksum)
//
// Seconds since it began (and how long the bytes took, where the line knows), direction, bytes in
// hex. Without a direction a line was received. Lines of candump ("(1700000000.123456) can0
// 181#3701") are read as well. Empty lines and those that begin with # are skipped.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tims/result.h"
#include "tims/time.h"

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

struct CaptureRecord {
  Duration time{};  // since the recording began; of candump since its epoch
  Direction direction = Direction::kReceived;
  std::uint32_t id = 0;
  Duration took{};  // from its first bit to its last
  std::vector<std::byte> bytes{};
  std::string event{};
};

std::string capture_header(std::string_view device, std::string_view date);

// One line, with its end. Does not allocate where `text` has room for it.
void append_record(std::string& text, Duration time, Direction direction, std::uint32_t id,
                   std::span<const std::byte> bytes, Duration took = {});
void append_event(std::string& text, Duration time, std::string_view event);

enum class RecordingFormat : std::uint8_t { kRaw, kCapture, kPcap };
// By how the file begins: some hundred bytes are enough.
RecordingFormat format_of(std::span<const std::byte> beginning);

// A line without its end, into `record`, whose memory is used again. False: nothing to play (empty,
// a comment). kMalformed: it is no line of a recording.
Result<bool> parse_record(std::string_view line, CaptureRecord& record);

}  // namespace rack::device
