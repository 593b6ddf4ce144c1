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

// "3.14" with so many digits behind the point.
std::string fixed(double value, int digits) {
  std::array<char, 400> text{};  // the largest double has 309 digits
  const auto end =
      std::to_chars(text.begin(), text.end(), value, std::chars_format::fixed, digits).ptr;
  return {text.begin(), end};
}

// With one digit behind the point, in the largest unit that leaves it above 1.
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

// A number that is not negative and its unit; `bare`: what a number without a unit is multiplied
// with.
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

}  // namespace tims::base
