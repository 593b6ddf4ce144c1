#include "proxies/gdos_texts.h"

#include <algorithm>
#include <array>
#include <charconv>

#include <fmt/format.h>
#include <unistd.h>

#include "os/environment.h"

namespace rack::gdos {

namespace {

// --- UTF-8

// A character and the bytes it takes; no bytes: there is none at the front.
struct Character {
  std::uint32_t code = 0;
  std::size_t bytes = 0;
};

Character first_of(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(text[i]) & 0xFF; };
  const std::uint32_t first = byte(0);
  if (first < 0x80) return {first, 1};
  const std::size_t bytes = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || bytes > text.size()) return {};
  std::uint32_t code = first & (0x7FU >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if (byte(i) >> 6 != 2) return {};
    code = code << 6 | (byte(i) & 0x3F);
  }
  // Written with more bytes than needed, half of a pair, or beyond the last character.
  constexpr std::array<std::uint32_t, 5> kSmallest = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xD800 && code < 0xE000;
  if (code < kSmallest.at(bytes) || surrogate || code > 0x10FFFF) return {};
  return {code, bytes};
}

void append_utf8(std::uint32_t code, std::string& out) {
  const auto put = [&out](std::uint32_t byte) { out += static_cast<char>(byte); };
  if (code < 0x80) return put(code);
  if (code < 0x800) {
    put(0xC0 | code >> 6);
  } else if (code < 0x10000) {
    put(0xE0 | code >> 12);
    put(0x80 | (code >> 6 & 0x3F));
  } else {
    put(0xF0 | code >> 18);
    put(0x80 | (code >> 12 & 0x3F));
    put(0x80 | (code >> 6 & 0x3F));
  }
  put(0x80 | (code & 0x3F));
}

// --- writing

bool is_control(std::uint32_t code) { return code < 0x20 || (code >= 0x7F && code < 0xA0); }

void append_string(std::string_view text, std::string& out) {
  out += '"';
  while (!text.empty()) {
    const Character c = first_of(text);
    if (c.code == '"' || c.code == '\\') out += '\\';
    if (is_control(c.code)) {
      out += fmt::format("\\u{:04x}", c.code);
    } else {
      append_utf8(c.code, out);
    }
    text.remove_prefix(c.bytes);
  }
  out += '"';
}

// --- reading: an object of strings

class Line {
 public:
  explicit Line(std::string_view line) : left_(line) {}

  template <typename Take>  // (key, value)
  bool read(Take take) {
    if (!skip('{')) return false;
    if (skip('}')) return at_end();
    do {
      const auto key = string();
      if (!key || !skip(':')) return false;
      const auto value = string();
      if (!value) return false;
      take(*key, *value);
    } while (skip(','));
    return skip('}') && at_end();
  }

 private:
  void blanks() { left_.remove_prefix(std::min(left_.find_first_not_of(" \t\r\n"), left_.size())); }
  bool skip(char wanted) {
    blanks();
    if (!left_.starts_with(wanted)) return false;
    left_.remove_prefix(1);
    return true;
  }
  bool at_end() {
    blanks();
    return left_.empty();
  }

  std::optional<std::string> string() {
    if (!skip('"')) return std::nullopt;
    std::string text;
    while (!left_.empty()) {
      const Character c = first_of(left_);
      if (c.bytes == 0 || c.code < 0x20) return std::nullopt;
      left_.remove_prefix(c.bytes);
      if (c.code == '"') return text;
      if (c.code != '\\') {
        append_utf8(c.code, text);
      } else if (!escape(text)) {
        return std::nullopt;
      }
    }
    return std::nullopt;
  }
  bool escape(std::string& text) {
    if (left_.empty()) return false;
    const char c = left_.front();
    left_.remove_prefix(1);
    if (c == 'u') return hexadecimal(text);
    constexpr std::string_view kNames = "\"\\/bfnrt";
    constexpr std::string_view kMeant = "\"\\/\b\f\n\r\t";
    const std::size_t at = kNames.find(c);
    if (at == std::string_view::npos) return false;
    text += kMeant[at];
    return true;
  }
  // Pairs that make one character are not what we write.
  bool hexadecimal(std::string& text) {
    std::uint32_t code = 0;
    if (left_.size() < 4) return false;
    const auto [end, error] = std::from_chars(left_.data(), left_.data() + 4, code, 16);
    if (error != std::errc() || end != left_.data() + 4) return false;
    if (code >= 0xD800 && code < 0xE000) return false;
    append_utf8(code, text);
    left_.remove_prefix(4);
    return true;
  }

  std::string_view left_;
};

template <typename Number>
std::optional<Number> digits(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool good = error == std::errc() && end == text.data() + text.size();
  return good && !text.empty() && text[0] != '-' ? std::optional(value) : std::nullopt;
}

std::optional<int> thousandths(std::string_view fraction) {
  if (fraction.empty()) return 0;
  if (fraction[0] != '.' || fraction.size() < 2) return std::nullopt;
  std::string three(fraction.substr(1, 3));
  if (!digits<std::uint64_t>(fraction.substr(1))) return std::nullopt;
  three.resize(3, '0');
  return digits<int>(three);
}

}  // namespace

std::string to_text(RecordTime time) {
  using namespace std::chrono;
  const auto day = floor<days>(time);
  const year_month_day date(day);
  const hh_mm_ss clock(time - day);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                     clock.hours().count(), clock.minutes().count(), clock.seconds().count(),
                     clock.subseconds().count());
}

std::optional<RecordTime> record_time(std::string_view text) {
  using namespace std::chrono;
  constexpr std::string_view kForm = "0000-00-00T00:00:00";
  if (text.size() <= kForm.size() || text.back() != 'Z') return std::nullopt;
  for (std::size_t i = 0; i < kForm.size(); ++i)
    if (kForm[i] != '0' && kForm[i] != text[i]) return std::nullopt;
  const auto part = [&](std::size_t at, std::size_t size) {
    return digits<int>(text.substr(at, size));
  };
  const auto y = part(0, 4);
  const auto m = part(5, 2);
  const auto d = part(8, 2);
  const auto hour = part(11, 2);
  const auto minute = part(14, 2);
  const auto second = part(17, 2);
  const auto ms = thousandths(text.substr(kForm.size(), text.size() - kForm.size() - 1));
  if (!y || !m || !d || !hour || !minute || !second || !ms) return std::nullopt;
  const auto date = year(*y) / month(static_cast<unsigned>(*m)) / day(static_cast<unsigned>(*d));
  if (!date.ok() || *hour > 23 || *minute > 59 || *second > 59) return std::nullopt;
  return sys_days(date) + hours(*hour) + minutes(*minute) + seconds(*second) + milliseconds(*ms);
}

std::string to_utf8(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    Character c = first_of(text);
    if (c.bytes == 0) c = {static_cast<std::uint32_t>(text[0]) & 0xFF, 1};
    const std::size_t before = out.size();
    append_utf8(c.code, out);
    if (out.size() > kTextMax) {
      out.resize(before);
      return out;
    }
    text.remove_prefix(c.bytes);
  }
  return out;
}

std::string to_line(const Record& record) {
  std::string line = "{";
  const auto field = [&line](std::string_view key, std::string_view value) {
    if (line.size() > 1) line += ',';
    append_string(key, line);
    line += ':';
    append_string(value, line);
  };
  field("time", to_text(record.time));
  field("address", record.address.to_hex());
  field("component", to_utf8(record.component));
  field("level", name(record.level));
  field("text", to_utf8(record.text));
  return line + "}\n";
}

std::optional<Record> record_of(std::string_view line) {
  Record record;
  std::optional<RecordTime> time;
  std::optional<tims::Address> address;
  std::optional<Level> level;
  const bool good = Line(line).read([&](std::string_view key, const std::string& value) {
    if (key == "time") time = record_time(value);
    if (key == "address") address = tims::Address::parse(value);
    if (key == "level") level = level_of(value);
    if (key == "component") record.component = to_utf8(value);
    if (key == "text") record.text = to_utf8(value);
  });
  if (!good || !time || !address || !level) return std::nullopt;
  record.time = *time;
  record.address = *address;
  record.level = *level;
  return record;
}

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBegin = "texts.";
constexpr std::string_view kEnd = ".jsonl";
const fs::path kOfTheHost = "/var/log/tims";

}  // namespace

std::string numbered_file(std::uint32_t number) {
  return fmt::format("{}{:06}{}", kBegin, number, kEnd);
}

std::optional<std::uint32_t> file_number(std::string_view name) {
  if (!name.starts_with(kBegin) || !name.ends_with(kEnd)) return std::nullopt;
  if (name.size() <= kBegin.size() + kEnd.size()) return std::nullopt;
  name = name.substr(kBegin.size(), name.size() - kBegin.size() - kEnd.size());
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  const bool good = error == std::errc() && end == name.data() + name.size();
  return good ? std::optional(number) : std::nullopt;
}

LogFiles log_files(const fs::path& folder) {
  LogFiles files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    files.current = files.current || name == kCurrentFile;
    if (const auto number = file_number(name)) files.numbers.push_back(*number);
  }
  std::ranges::sort(files.numbers);
  return files;
}

std::vector<fs::path> log_paths(const fs::path& folder) {
  const LogFiles files = log_files(folder);
  std::vector<fs::path> paths;
  paths.reserve(files.numbers.size() + 1);
  for (const std::uint32_t number : files.numbers) paths.push_back(folder / numbered_file(number));
  if (files.current) paths.push_back(folder / kCurrentFile);
  return paths;
}

fs::path folder_to_write() {
  if (const std::string given = tims::os::environment("LOGS_DIRECTORY"); !given.empty())
    return given.substr(0, given.find(':'));
  if (::geteuid() == 0) return kOfTheHost;
  if (const std::string state = tims::os::environment("XDG_STATE_HOME"); !state.empty())
    return fs::path(state) / "tims";
  return fs::path(tims::os::environment("HOME")) / ".local/state/tims";
}

fs::path folder_to_read() {
  const fs::path own = folder_to_write();
  return log_paths(own).empty() ? kOfTheHost : own;
}

}  // namespace rack::gdos
