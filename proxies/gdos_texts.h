// The stored form of a log text: one line of JSON in a file, for grep, jq and human readers.
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
  std::string component{};  // text form of the address, with the widths of its fleet
  Level level = Level::kPrint;
  std::string text{};

  bool operator==(const Record&) const = default;
};

// With its line end. The line is always valid JSON in UTF-8 without control characters, whatever
// the text contains.
std::string to_line(const Record& record);
// Nothing: the line does not have this form. Unknown keys are ignored.
std::optional<Record> record_of(std::string_view line);

// "2026-11-22T03:00:00.123Z"; the fraction is optional in input.
std::string to_text(RecordTime time);
std::optional<RecordTime> record_time(std::string_view text);

// UTF-8 of at most kTextMax bytes. Bytes that are not valid UTF-8 are interpreted as ISO 8859-1,
// the encoding of the original programs.
std::string to_utf8(std::string_view text);

// --- Splits a file into texts, chunk by chunk: a line may end in the next chunk. Invalid lines are
// counted and skipped.

class RecordReader {
 public:
  // We never write a longer line; a longer one is invalid.
  static constexpr std::size_t kLineMax = 16384;

  template <typename Take>  // take(Record&&)
  void read(std::string_view piece, Take take) {
    while (!piece.empty()) {
      const std::size_t end = piece.find('\n');
      add(piece.substr(0, end));
      if (end == std::string_view::npos) return;
      if (auto record = finish_line()) take(std::move(*record));
      piece.remove_prefix(end + 1);
    }
  }
  // The last line may be incomplete: without its line end it is not parsed.

  [[nodiscard]] std::uint64_t strange() const { return strange_; }  // number of invalid lines

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

// --- Location of the log files of a robot, shared by the writer and the readers.

// The file that is written to. Its earlier content is in texts.000001.jsonl and so on; the newest
// has the highest number.
inline constexpr std::string_view kCurrentFile = "texts.jsonl";
std::string numbered_file(std::uint32_t number);
std::optional<std::uint32_t> file_number(std::string_view name);

struct LogFiles {
  std::vector<std::uint32_t> numbers;  // ascending
  bool current = false;
  [[nodiscard]] std::uint32_t next_number() const {
    return numbers.empty() ? 1 : numbers.back() + 1;
  }
};
LogFiles log_files(const std::filesystem::path& folder);
// Oldest first.
std::vector<std::filesystem::path> log_paths(const std::filesystem::path& folder);

// $LOGS_DIRECTORY (set by systemd for a unit); else /var/log/tims for root, and
// $XDG_STATE_HOME/tims or ~/.local/state/tims for other users.
std::filesystem::path folder_to_write();
// The same directory if it contains texts; else /var/log/tims.
std::filesystem::path folder_to_read();

}  // namespace rack::gdos
