// A text as it is kept: one line of JSON in a file, for grep, jq and people.
//
//   {"time":"2026-11-22T03:00:00.123Z","address":"0x00110000","component":"Chassis(0/0)",
//    "level":"warning","text":"Listener GUI(0/0) is gone"}
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rack/proxies/gdos.h"

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

// --- The texts of a file, piece by piece: a line may end in the next piece, and what is no text is
// counted and passed over.

class RecordReader {
 public:
  // No line of ours is longer. What is, is no text.
  static constexpr std::size_t kLineMax = 16384;

  template <typename Take>  // (Record&&)
  void read(std::string_view piece, Take take) {
    while (!piece.empty()) {
      const std::size_t end = piece.find('\n');
      add(piece.substr(0, end));
      if (end == std::string_view::npos) return;
      if (auto record = finish_line()) take(std::move(*record));
      piece.remove_prefix(end + 1);
    }
  }
  // The last line may still be written to: without its end it is not looked at.

  [[nodiscard]] std::uint64_t strange() const { return strange_; }  // lines that are no texts

 private:
  void add(std::string_view part) {
    too_long_ = too_long_ || line_.size() + part.size() > kLineMax;
    if (!too_long_) line_ += part;
  }
  std::optional<Record> finish_line() {
    auto record = too_long_ ? std::nullopt : record_of(line_);
    if (!record) ++strange_;
    line_.clear();
    too_long_ = false;
    return record;
  }

  std::string line_;
  bool too_long_ = false;
  std::uint64_t strange_ = 0;
};

// --- Where the texts of a robot are kept: what writes them and what reads them agree here.

// The file that grows; what it held before is in texts.000001.jsonl and so on, the newest with the
// highest number.
inline constexpr std::string_view kCurrentFile = "texts.jsonl";
std::string numbered_file(std::uint32_t number);
std::optional<std::uint32_t> file_number(std::string_view name);

struct LogFiles {
  std::vector<std::uint32_t> numbers;  // rising
  bool current = false;
  [[nodiscard]] std::uint32_t next_number() const {
    return numbers.empty() ? 1 : numbers.back() + 1;
  }
};
LogFiles log_files(const std::filesystem::path& folder);
// Oldest first.
std::vector<std::filesystem::path> log_paths(const std::filesystem::path& folder);

// $LOGS_DIRECTORY (what a systemd unit has); else /var/log/tims for root, and $XDG_STATE_HOME/tims
// or
// ~/.local/state/tims for others.
std::filesystem::path folder_to_write();
// The same where texts are there; else /var/log/tims.
std::filesystem::path folder_to_read();

}  // namespace rack::gdos
