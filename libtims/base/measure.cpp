#include "base/measure.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "base/text.h"

namespace tims::base {

constexpr std::array<Unit, 6> kDurationUnits{
    Unit{"ns", 1},
    Unit{"us", 1'000},
    Unit{"ms", 1'000'000},
    Unit{"s", 1'000'000'000},
    Unit{"min", 60'000'000'000},
    Unit{"h", 3'600'000'000'000},
};
constexpr std::array<Unit, 4> kSizeUnits{
    Unit{"B", 1},
    Unit{"KiB", 1LL << 10},
    Unit{"MiB", 1LL << 20},
    Unit{"GiB", 1LL << 30},
};
constexpr std::array<Unit, 4> kRateUnits{
    Unit{"B", 1},
    Unit{"kB", 1'000},
    Unit{"MB", 1'000'000},
    Unit{"GB", 1'000'000'000},
};
constexpr std::array<Unit, 8> kSizeUnitsRead{
    Unit{"", 1},
    Unit{"B", 1},
    Unit{"kB", 1'000},
    Unit{"MB", 1'000'000},
    Unit{"GB", 1'000'000'000},
    Unit{"KiB", 1LL << 10},
    Unit{"MiB", 1LL << 20},
    Unit{"GiB", 1LL << 30},
};

namespace {

// "3.14" with the given number of digits after the point.
std::string fixed(double value, int digits) {
  std::array<char, 400> text{};  // the largest double has 309 digits
  const auto end =
      std::to_chars(text.begin(), text.end(), value, std::chars_format::fixed, digits).ptr;
  return {text.begin(), end};
}

// With one digit after the point, in the largest unit that leaves the number above 1.
std::string scaled(double value, double base, std::span<const std::string_view> units) {
  std::size_t unit = 0;
  while (std::abs(value) >= base && unit + 1 < units.size()) {
    value /= base;
    ++unit;
  }
  return fixed(value, unit == 0 ? 0 : 1).append(units[unit]);
}

// "2m 10s"
std::string of_two(std::int64_t whole, std::string_view unit, std::int64_t rest,
                   std::string_view rest_unit) {
  return std::to_string(whole)
      .append(unit)
      .append(" ")
      .append(std::to_string(rest))
      .append(rest_unit);
}

// A non-negative number with its unit. `bare`: factor of a number without a unit.
std::optional<double> parse_measure(std::string_view text, std::span<const Unit> units,
                                    double bare) {
  const std::size_t digits = std::min(text.find_first_not_of("0123456789."), text.size());
  double number = 0;
  const char* const end = text.data() + digits;
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || stop != end || !std::isfinite(number)) return std::nullopt;
  const std::string_view name = text.substr(digits);
  if (name.empty()) return number * bare;
  const auto unit = std::ranges::find(units, name, &Unit::name);
  if (unit == units.end()) return std::nullopt;
  return number * static_cast<double>(unit->factor);
}

}  // namespace

Measure read_measure(std::string_view text, std::span<const Unit> units) {
  Measure read;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, read.count);
  if (error == std::errc::invalid_argument) return {.error = MeasureError::kNoNumber};
  read.unit = {stop, static_cast<std::size_t>(end - stop)};
  const auto unit = std::ranges::find(units, read.unit, &Unit::name);
  if (unit == units.end())
    read.error = read.unit.empty() ? MeasureError::kNoUnit : MeasureError::kUnknownUnit;
  else if (error == std::errc::result_out_of_range ||
           __builtin_mul_overflow(read.count, unit->factor, &read.count))
    read.error = MeasureError::kTooLarge;
  return read;
}

std::optional<Duration> parse_duration(std::string_view text) {
  const std::string whole = std::string(text) + (text.ends_with('m') ? "in" : "");
  const auto ns = parse_measure(whole, kDurationUnits, 1e9);
  if (!ns || *ns > 1e18) return std::nullopt;
  return Duration(std::llround(*ns));
}

std::optional<std::uint32_t> parse_size(std::string_view text) {
  const auto bytes = parse_measure(text, kSizeUnitsRead, 1);
  if (!bytes || *bytes > std::numeric_limits<std::uint32_t>::max()) return std::nullopt;
  return static_cast<std::uint32_t>(*bytes);
}

std::string exact_text(std::int64_t count, std::span<const Unit> units) {
  const Unit* best = &units.front();
  for (const Unit& unit : units)
    if (count != 0 && count % unit.factor == 0) best = &unit;
  return std::to_string(count / best->factor).append(best->name);
}

std::string human_count(double value) {
  constexpr std::array<std::string_view, 5> kUnits = {"", "k", "M", "G", "T"};
  if (value < 100'000) return fixed(value, 0);
  return scaled(value, 1000, kUnits);
}

std::string human_bytes(double value) {
  constexpr std::array<std::string_view, 5> kUnits = {" B", " KiB", " MiB", " GiB", " TiB"};
  return scaled(value, 1024, kUnits);
}

std::string human_duration(double seconds) {
  if (seconds < 0) return "-" + human_duration(-seconds);
  if (seconds == 0) return "0s";
  if (seconds < 1e-3) return fixed(seconds * 1e6, 1) + "us";
  if (seconds < 1) return fixed(seconds * 1e3, 2) + "ms";
  if (seconds < 60) return fixed(seconds, 2) + "s";
  const auto whole = static_cast<std::int64_t>(seconds);
  if (whole < 3600) return of_two(whole / 60, "m", whole % 60, "s");
  if (whole < 86400) return of_two(whole / 3600, "h", whole / 60 % 60, "m");
  return of_two(whole / 86400, "d", whole / 3600 % 24, "h");
}

std::string human_rate(double per_second) {
  if (per_second >= 1000) return human_count(per_second);
  return fixed(per_second, per_second >= 10 || per_second == 0 ? 1 : 2);
}

// --- calendar

namespace {

using namespace std::chrono;

std::string padded(std::int64_t number, std::size_t digits) {
  const std::string text = std::to_string(number);
  return std::string(digits - std::min(digits, text.size()), '0') + text;
}

std::string clock_text(WallTime time, int digits) {
  const hh_mm_ss clock(time - floor<days>(time));
  std::string text = padded(clock.hours().count(), 2) + ":" + padded(clock.minutes().count(), 2) +
                     ":" + padded(clock.seconds().count(), 2);
  const std::string fraction = padded(clock.subseconds().count(), 9);
  if (digits > 0) text.append(".").append(fraction, 0, static_cast<std::size_t>(digits));
  return text;
}

// Nanoseconds in 64 bits cover the years 1678 to 2261 only.
constexpr year kFirstYear(1678);
constexpr year kLastYear(2261);

// "" or ".123"
std::optional<nanoseconds> parse_fraction(std::string_view text) {
  if (text.empty()) return nanoseconds(0);
  if (text.front() != '.' || text.size() < 2) return std::nullopt;
  std::string digits(text.substr(1, 9));
  if (text.find_first_not_of("0123456789", 1) != std::string_view::npos) return std::nullopt;
  digits.resize(9, '0');
  return nanoseconds(*parse_number<std::int64_t>(digits));
}

}  // namespace

std::string rfc3339(WallTime time, int digits) {
  return date(time) + "T" + clock_text(time, digits) + "Z";
}

std::optional<WallTime> parse_rfc3339(std::string_view text) {
  constexpr std::string_view kForm = "0000-00-00T00:00:00";
  if (text.size() <= kForm.size() || text.back() != 'Z') return std::nullopt;
  const auto fits = [](char c, char form) {
    return form == '0' ? c >= '0' && c <= '9' : c == form;
  };
  if (!std::ranges::equal(text.substr(0, kForm.size()), kForm, fits)) return std::nullopt;
  const auto part = [&](std::size_t at, std::size_t size) {
    return *parse_number<int>(text.substr(at, size));
  };
  const auto day = year(part(0, 4)) / month(static_cast<unsigned>(part(5, 2))) /
                   std::chrono::day(static_cast<unsigned>(part(8, 2)));
  if (day.year() < kFirstYear || day.year() > kLastYear) return std::nullopt;
  const int hour = part(11, 2);
  const int minute = part(14, 2);
  const int second = part(17, 2);
  const auto fraction = parse_fraction(text.substr(kForm.size(), text.size() - kForm.size() - 1));
  if (!day.ok() || hour > 23 || minute > 59 || second > 59 || !fraction) return std::nullopt;
  return sys_days(day) + hours(hour) + minutes(minute) + std::chrono::seconds(second) + *fraction;
}

std::string date(WallTime time) {
  const year_month_day date(floor<days>(time));
  return padded(static_cast<int>(date.year()), 4) + "-" +
         padded(static_cast<unsigned>(date.month()), 2) + "-" +
         padded(static_cast<unsigned>(date.day()), 2);
}

std::string time_of_day(WallTime time) { return clock_text(time, 3); }

}  // namespace tims::base
