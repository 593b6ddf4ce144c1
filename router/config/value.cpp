#include "router/config/value.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <span>

#include <fmt/core.h>

namespace tims::config {
namespace {

struct Unit {
  std::string_view name;
  std::int64_t factor;
};
// Ascending; the first is the base and always divides.
constexpr std::array kDurationUnits{
    Unit{"ns", 1},
    Unit{"us", 1'000},
    Unit{"ms", 1'000'000},
    Unit{"s", 1'000'000'000},
    Unit{"min", 60'000'000'000},
    Unit{"h", 3'600'000'000'000},
};
// For printing: powers of 1024. Reading also knows the powers of 1000.
constexpr std::array kSizeUnits{
    Unit{"B", 1},
    Unit{"KiB", 1LL << 10},
    Unit{"MiB", 1LL << 20},
    Unit{"GiB", 1LL << 30},
};
constexpr std::array kSizeUnitsRead{
    Unit{"", 1},
    Unit{"B", 1},
    Unit{"kB", 1'000},
    Unit{"MB", 1'000'000},
    Unit{"GB", 1'000'000'000},
    Unit{"KiB", 1LL << 10},
    Unit{"MiB", 1LL << 20},
    Unit{"GiB", 1LL << 30},
};
constexpr std::array<std::string_view, 4> kLogLevels{"error", "warning", "info", "debug"};

Error bad(std::string detail) { return {Errc::kInvalidArgument, std::move(detail)}; }

Error unreadable(Kind kind, std::string_view text) {
  return bad(fmt::format("wants {}, not {}", kind_example(kind), in_quotes(text)));
}

std::string with_unit(std::int64_t count, std::span<const Unit> units) {
  const Unit* best = &units.front();
  for (const Unit& unit : units)
    if (count != 0 && count % unit.factor == 0) best = &unit;
  return fmt::format("{}{}", count / best->factor, best->name);
}

template <typename Units>
std::string unit_list(const Units& units) {
  std::string list;
  for (const Unit& unit : units)
    if (!unit.name.empty()) list += fmt::format("{}{}", list.empty() ? "" : ", ", unit.name);
  return list;
}

template <typename Units>
Result<std::int64_t> parse_with_unit(Kind kind, std::string_view text, const Units& units) {
  std::int64_t count = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (error == std::errc::invalid_argument) return unreadable(kind, text);
  const std::string_view name(end, static_cast<std::size_t>(text.data() + text.size() - end));
  const auto unit = std::ranges::find(units, name, &Unit::name);
  if (unit == units.end() && name.empty()) return unreadable(kind, text);
  if (unit == units.end())
    return bad(fmt::format("has the unknown unit {} in {}; known are {}", in_quotes(name),
                           in_quotes(text), unit_list(units)));
  std::int64_t product = 0;
  if (error == std::errc::result_out_of_range ||
      __builtin_mul_overflow(count, unit->factor, &product))
    return bad(fmt::format("{} is too large to be counted", in_quotes(text)));
  return product;
}

Result<Value> parse_number(Kind kind, std::string_view text) {
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return unreadable(kind, text);
  return Value(number);
}

Result<Value> parse_log_level(std::string_view text) {
  const auto* const found = std::ranges::find(kLogLevels, text);
  if (found == kLogLevels.end()) return unreadable(Kind::kLogLevel, text);
  return Value(static_cast<LogLevel>(found - kLogLevels.begin()));
}

// The value's text without looking at the limits.
Result<Value> parse_any(Kind kind, std::string_view text) {
  switch (kind) {
    case Kind::kText:
      return Value(std::string(text));
    case Kind::kFlag:
      if (text != "true" && text != "false") return unreadable(kind, text);
      return Value(text == "true");
    case Kind::kNumber:
      return parse_number(kind, text);
    case Kind::kDuration: {
      const auto count = parse_with_unit(kind, text, kDurationUnits);
      if (!count) return count.error();
      return Value(Duration(*count));
    }
    case Kind::kSize: {
      const auto count = parse_with_unit(kind, text, kSizeUnitsRead);
      if (!count) return count.error();
      return Value(Bytes{*count});
    }
    case Kind::kEndpoint: {
      if (text == "off") return Value(std::optional<Endpoint>());
      auto endpoint = Endpoint::parse(text);
      if (!endpoint) return unreadable(kind, text);
      return Value(std::move(endpoint));
    }
    case Kind::kLogLevel:
      return parse_log_level(text);
  }
  return unreadable(kind, text);
}

// What the range is compared with; nothing where the kind has no range.
std::optional<std::int64_t> measure(const Value& value) {
  if (const auto* text = std::get_if<std::string>(&value))
    return static_cast<std::int64_t>(text->size());
  if (const auto* number = std::get_if<std::int64_t>(&value)) return *number;
  if (const auto* duration = std::get_if<Duration>(&value)) return duration->count();
  if (const auto* bytes = std::get_if<Bytes>(&value)) return bytes->count;
  return std::nullopt;
}

std::string measure_text(Kind kind, std::int64_t measure) {
  if (kind == Kind::kDuration) return with_unit(measure, kDurationUnits);
  if (kind == Kind::kSize) return with_unit(measure, kSizeUnits);
  return std::to_string(measure);
}

// "$" as "$$", so that reading the text back replaces nothing.
std::string without_substitution(std::string_view text) {
  std::string out;
  for (const char c : text) out.append(c == '$' ? 2 : 1, c);
  return out;
}

bool is_control(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }

}  // namespace

Result<Value> parse_value(Kind kind, Range range, std::string_view text) {
  auto value = parse_any(kind, text);
  if (!value) return value;
  const auto checked = check_range(kind, range, *value);
  return checked ? std::move(value) : checked.error();
}

Result<void> check_range(Kind kind, Range range, const Value& value) {
  const auto* text = std::get_if<std::string>(&value);
  if (text != nullptr && std::ranges::any_of(*text, is_control))
    return bad(fmt::format("{} holds a control character", in_quotes(*text)));
  const auto size = measure(value);
  if (!size || (*size >= range.min && *size <= range.max)) return {};
  return bad(fmt::format("{} is out of range ({})",
                         text != nullptr ? in_quotes(*text) : measure_text(kind, *size),
                         range_text(kind, range)));
}

std::string to_toml(const Value& value) {
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* number = std::get_if<std::int64_t>(&value)) return std::to_string(*number);
  if (const auto* duration = std::get_if<Duration>(&value))
    return in_quotes(measure_text(Kind::kDuration, duration->count()));
  if (const auto* bytes = std::get_if<Bytes>(&value))
    return in_quotes(measure_text(Kind::kSize, bytes->count));
  if (const auto* level = std::get_if<LogLevel>(&value))
    return in_quotes(kLogLevels.at(static_cast<std::size_t>(*level)));
  if (const auto* endpoint = std::get_if<std::optional<Endpoint>>(&value))
    return in_quotes(*endpoint ? (*endpoint)->to_string() : "off");
  return in_quotes(without_substitution(std::get<std::string>(value)));
}

std::string in_quotes(std::string_view text) {
  std::string out(1, '"');
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += {'\\', c};
    } else if (is_control(c)) {
      out += fmt::format("\\u{:04X}", c);
    } else {
      out += c;
    }
  }
  out += '"';
  return out;
}

std::string_view kind_name(Kind kind) {
  static constexpr std::array<std::string_view, 7> kNames{
      "text", "true or false", "number", "duration", "size", "address:port or off", "level"};
  return kNames.at(static_cast<std::size_t>(kind));
}

std::string_view kind_example(Kind kind) {
  static constexpr std::array<std::string_view, 7> kExamples{
      R"(a text such as "robot1")",
      "true or false",
      "a whole number",
      R"(a duration with its unit such as "250ms" or "5s")",
      R"(a size such as "4MiB" or 262144 (bytes))",
      R"(a numeric address and port such as "127.0.0.1:2000", "0.0.0.0:2000" (all interfaces))"
      R"( or "[::1]:2000", or "off")",
      R"("error", "warning", "info" or "debug")"};
  return kExamples.at(static_cast<std::size_t>(kind));
}

std::string range_text(Kind kind, Range range) {
  if (kind == Kind::kFlag || kind == Kind::kEndpoint) return {};
  if (kind == Kind::kLogLevel) return "error, warning, info, debug";
  return fmt::format("{} to {}{}", measure_text(kind, range.min), measure_text(kind, range.max),
                     kind == Kind::kText ? " bytes long" : "");
}

}  // namespace tims::config
