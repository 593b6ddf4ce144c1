#include "tools/timsctl/humanize.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <ctime>
#include <span>

#include <fmt/format.h>

namespace timsctl {

namespace {

// Three digits of `value` in the largest unit that leaves it above 1.
std::string scaled(double value, double base, std::span<const std::string_view> units) {
  std::size_t unit = 0;
  while (std::abs(value) >= base && unit + 1 < units.size()) {
    value /= base;
    ++unit;
  }
  if (unit == 0) return fmt::format("{:.0f}{}", value, units[0]);
  return fmt::format("{:.1f}{}", value, units[unit]);
}

// Length of the UTF-8 character at the front, 0 when it is none.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(0);
  const std::size_t length = first < 0x80       ? 1
                             : first >> 5 == 6  ? 2
                             : first >> 4 == 14 ? 3
                             : first >> 3 == 30 ? 4
                                                : 0;
  if (length == 0 || length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if (byte(i) >> 6 != 2) return 0;
  return length;
}

}  // namespace

std::string human_count(double value) {
  constexpr std::array<std::string_view, 5> kUnits = {"", "k", "M", "G", "T"};
  if (value < 100'000) return fmt::format("{:.0f}", value);
  return scaled(value, 1000, kUnits);
}

std::string human_bytes(double value) {
  constexpr std::array<std::string_view, 5> kUnits = {" B", " KiB", " MiB", " GiB", " TiB"};
  return scaled(value, 1024, kUnits);
}

std::string human_duration(double seconds) {
  if (seconds < 0) return fmt::format("-{}", human_duration(-seconds));
  if (seconds == 0) return "0s";
  if (seconds < 1e-3) return fmt::format("{:.1f}us", seconds * 1e6);
  if (seconds < 1) return fmt::format("{:.2f}ms", seconds * 1e3);
  if (seconds < 60) return fmt::format("{:.2f}s", seconds);
  const auto whole = static_cast<std::int64_t>(seconds);
  if (whole < 3600) return fmt::format("{}m {}s", whole / 60, whole % 60);
  if (whole < 86400) return fmt::format("{}h {}m", whole / 3600, whole / 60 % 60);
  return fmt::format("{}d {}h", whole / 86400, whole / 3600 % 24);
}

std::string human_rate(double per_second) {
  if (per_second >= 1000) return human_count(per_second);
  if (per_second >= 10 || per_second == 0) return fmt::format("{:.1f}", per_second);
  return fmt::format("{:.2f}", per_second);
}

std::string rfc3339(WallTime time) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(time);
  const std::time_t whole = seconds.time_since_epoch().count();
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(time - seconds).count();
  std::tm fields{};
  ::gmtime_r(&whole, &fields);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:06}Z", fields.tm_year + 1900,
                     fields.tm_mon + 1, fields.tm_mday, fields.tm_hour, fields.tm_min,
                     fields.tm_sec, us);
}

std::string time_of_day(WallTime time, bool utc) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(time);
  const std::time_t whole = seconds.time_since_epoch().count();
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(time - seconds).count();
  std::tm fields{};
  utc ? ::gmtime_r(&whole, &fields) : ::localtime_r(&whole, &fields);
  return fmt::format("{:02}:{:02}:{:02}.{:03}{}", fields.tm_hour, fields.tm_min, fields.tm_sec, ms,
                     utc ? "Z" : "");
}

std::optional<WallTime> parse_rfc3339(std::string_view text) {
  std::tm fields{};
  const std::string copy(text);
  const char* rest = ::strptime(copy.c_str(), "%Y-%m-%dT%H:%M:%S", &fields);
  if (rest == nullptr) return std::nullopt;
  double fraction = 0;
  if (*rest == '.') std::from_chars(rest, copy.c_str() + copy.size(), fraction);
  const auto whole = std::chrono::sys_seconds(std::chrono::seconds(::timegm(&fields)));
  return whole + std::chrono::nanoseconds(std::llround(fraction * 1e9));
}

std::string local_time(std::string_view rfc3339_text, bool utc) {
  const auto time = parse_rfc3339(rfc3339_text);
  return time ? time_of_day(*time, utc) : std::string(rfc3339_text);
}

WallTime wall_now() {
  return std::chrono::time_point_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now());
}

std::chrono::sys_time<std::chrono::milliseconds> wall_now_ms() {
  return std::chrono::floor<std::chrono::milliseconds>(wall_now());
}

std::string printable(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const auto first = static_cast<unsigned char>(text.front());
    // 0xC2 0x80..0x9F are control characters as well.
    const bool control =
        first < 0x20 || first == 0x7F ||
        (first == 0xC2 && length == 2 && static_cast<unsigned char>(text[1]) < 0xA0);
    if (length == 0 || control)
      out += '?';
    else
      out += text.substr(0, length);
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return out;
}

std::string printable_lines(std::string_view text) {
  std::string out;
  for (;;) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    out += printable(text.substr(0, end));
    if (end == text.size()) return out;
    out += '\n';
    text.remove_prefix(end + 1);
  }
}

std::size_t display_width(std::string_view text) {
  std::size_t width = 0;
  for (const char c : text)
    if ((static_cast<unsigned char>(c) & 0xC0) != 0x80) ++width;
  return width;
}

}  // namespace timsctl
