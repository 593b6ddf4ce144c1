#include "tools/timsctl/text_filter.h"

#include <array>
#include <ctime>

#include <fmt/format.h>

#include "base/measure.h"
#include "base/text.h"
#include "base/wall_time.h"
#include "tools/cli/arguments.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"

namespace timsctl {

using rack::gdos::Level;
using rack::gdos::Record;
using rack::gdos::RecordTime;

namespace {

Tone tone_of(Level level) {
  switch (level) {
    case Level::kError:
      return Tone::kBad;
    case Level::kWarning:
      return Tone::kWarning;
    case Level::kInfo:
      return Tone::kGood;
    case Level::kDetail:
      return Tone::kDim;
    case Level::kPrint:
      break;
  }
  return Tone::kPlain;
}

std::tm fields_of(RecordTime time, bool utc) {
  const std::time_t whole =
      std::chrono::floor<std::chrono::seconds>(time).time_since_epoch().count();
  std::tm fields{};
  utc ? ::gmtime_r(&whole, &fields) : ::localtime_r(&whole, &fields);
  return fields;
}

RecordTime time_of(std::tm fields, bool utc) {
  fields.tm_isdst = -1;
  return RecordTime(std::chrono::seconds(utc ? ::timegm(&fields) : ::mktime(&fields)));
}

std::string day_of(RecordTime time, bool utc) {
  const std::tm fields = fields_of(time, utc);
  return fmt::format("{:04}-{:02}-{:02}", fields.tm_year + 1900, fields.tm_mon + 1, fields.tm_mday);
}

// What is missing of a date comes from `fields`. All of the text must be used.
bool parse_with(const char* form, const std::string& text, std::tm& fields) {
  std::tm parsed = fields;
  const char* const end = ::strptime(text.c_str(), form, &parsed);
  if (end == nullptr || *end != 0) return false;
  fields = parsed;
  return true;
}

RecordTime need_when(const std::string& text, RecordTime now, bool utc) {
  if (const auto time = parse_when(text, now, utc)) return *time;
  throw usage_error(
      "\"" + text + "\" is no time",
      "10min (ago), 03:15, 2026-11-22, '2026-11-22 03:15:30' or the same with T and Z");
}

}  // namespace

std::optional<RecordTime> parse_when(std::string_view text, RecordTime now, bool utc) {
  if (const auto ago = base::parse_duration(text))
    return now - std::chrono::floor<std::chrono::milliseconds>(*ago);
  if (const auto exact = rack::gdos::record_time(text)) return exact;
  const bool zulu = text.ends_with('Z');
  const std::string plain(text.substr(0, text.size() - (zulu ? 1 : 0)));
  utc = utc || zulu;
  std::tm fields = fields_of(now, utc);
  fields.tm_hour = fields.tm_min = fields.tm_sec = 0;
  for (const char* form : {"%Y-%m-%d", "%Y-%m-%d %H:%M", "%Y-%m-%d %H:%M:%S", "%Y-%m-%dT%H:%M",
                           "%Y-%m-%dT%H:%M:%S", "%H:%M", "%H:%M:%S"})
    if (parse_with(form, plain, fields)) return time_of(fields, utc);
  return std::nullopt;
}

TextFilter text_filter(const Options& options, const tims::AddressWidths& widths, RecordTime now) {
  TextFilter filter;
  if (!options.component.empty()) filter.component = need_pattern(options.component, widths);
  if (options.level) filter.level = *options.level;
  if (!options.since.empty()) filter.since = need_when(options.since, now, options.utc);
  if (!options.until.empty()) filter.until = need_when(options.until, now, options.utc);
  return filter;
}

bool TextFilter::passes(const Record& record) const {
  return record.level >= level && component.matches(record.address) &&
         (!since || record.time >= *since) && (!until || record.time <= *until);
}

void show_text(Output& out, const Record& record, bool with_day) {
  const std::string_view level = rack::gdos::name(record.level);
  if (out.json())
    return out.write(
        json::object{{"schema", "tims/text/1"},
                     {"time", rack::gdos::to_text(record.time)},
                     {"address", {{"name", record.component}, {"raw", record.address.to_hex()}}},
                     {"level", level},
                     {"text", record.text}});
  const bool utc = out.look().utc;
  const std::string day = with_day ? day_of(record.time, utc) + " " : "";
  const std::string line = fmt::format("{}{} {:<18} {:<7} {}", day, time_of_day(record.time, utc),
                                       record.component, level, record.text);
  out.write(paint(base::printable(line), tone_of(record.level), out.look().colour) + "\n");
}

}  // namespace timsctl
