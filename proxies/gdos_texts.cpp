#include "proxies/gdos_texts.h"

#include <algorithm>

#include <boost/json/parse.hpp>
#include <fmt/format.h>
#include <unistd.h>

#include "base/measure.h"
#include "base/text.h"
#include "os/environment.h"

namespace rack::gdos {

std::string to_text(RecordTime time) { return tims::base::rfc3339(time, 3); }

std::optional<RecordTime> record_time(std::string_view text) {
  const auto time = tims::base::parse_rfc3339(text);
  if (!time) return std::nullopt;
  return std::chrono::floor<std::chrono::milliseconds>(*time);
}

std::string to_utf8(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    tims::base::Character c = tims::base::first_character(text);
    if (c.bytes == 0) c = {static_cast<std::uint32_t>(text[0]) & 0xFF, 1};
    const std::size_t before = out.size();
    tims::base::append_utf8(c.code, out);
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
    line.append(tims::base::in_quotes(key)).append(":").append(tims::base::in_quotes(value));
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
  boost::system::error_code error;
  const boost::json::value parsed = boost::json::parse(line, error);
  if (error || !parsed.is_object()) return std::nullopt;
  for (const auto& [key, member] : parsed.get_object()) {
    const boost::json::string* value = member.if_string();
    if (value == nullptr) return std::nullopt;
    if (key == "time") time = record_time(*value);
    if (key == "address") address = tims::Address::parse(*value);
    if (key == "level") level = level_of(*value);
    if (key == "component") record.component = to_utf8(*value);
    if (key == "text") record.text = to_utf8(*value);
  }
  if (!time || !address || !level) return std::nullopt;
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
  return tims::base::parse_number<std::uint32_t>(name);
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
