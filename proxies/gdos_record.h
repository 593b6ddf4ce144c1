// A text as it is kept: one line of JSON in a file, for grep, jq and people.
//
//   {"time":"2026-11-22T03:00:00.123Z","address":"0x00110000","component":"Chassis(0/0)",
//    "level":"warning","text":"Listener GUI(0/0) is gone"}
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "proxies/gdos.h"

namespace rack::gdos {

using RecordTime = std::chrono::sys_time<std::chrono::milliseconds>;

struct Record {
  RecordTime time{};
  tims::Address address{};  // of the sender
  std::string component{};  // the same as people read it, with the widths of its fleet
  Level level = Level::kPrint;
  std::string text{};

  bool operator==(const Record&) const = default;
};

// With its line end. Whatever the text holds, the line is valid JSON in UTF-8 and has no control
// character.
std::string to_line(const Record& record);
// Nothing: the line is not of this kind. Keys that are not known here are passed over.
std::optional<Record> record_of(std::string_view line);

// "2026-11-22T03:00:00.123Z"; with or without the fraction when read.
std::string to_text(RecordTime time);
std::optional<RecordTime> record_time(std::string_view text);

// At most kTextMax bytes, in UTF-8. Bytes that are none are taken for the ISO 8859-1 that programs
// of the original were written in.
std::string to_utf8(std::string_view text);

}  // namespace rack::gdos
