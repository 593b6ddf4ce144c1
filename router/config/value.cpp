#include "router/config/value.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <span>

#include <fmt/ranges.h>

#include "base/measure.h"
#include "base/text.h"

namespace tims::config {
namespace {

using base::kDurationUnits;
using base::kRateUnits;
using base::kSizeUnits;
using base::kSizeUnitsRead;
using base::MeasureError;
using base::Unit;

// In the order of the enumeration.
constexpr std::array<std::string_view, 4> kLogLevels{"error", "warning", "info", "debug"};
constexpr auto kRoles = core::names(core::kRoles);
constexpr auto kLinkKinds = core::names(core::kLinkKinds);
constexpr auto kCompressions = core::names(core::kCompressions);
constexpr auto kPaths = core::names(core::kPathKinds);

std::span<const std::string_view> names_of(Kind kind) {
  if (kind == Kind::kLogLevel) return kLogLevels;
  if (kind == Kind::kRole) return kRoles;
  if (kind == Kind::kLinkKind) return kLinkKinds;
  if (kind == Kind::kCompression) return kCompressions;
  return {};
}

Error bad(std::string detail) { return {Errc::kInvalidArgument, std::move(detail)}; }

Error unreadable(Kind kind, std::string_view text) {
  return bad(fmt::format("must be {}, not {}", kind_example(kind), in_quotes(text)));
}

std::string unit_list(std::span<const Unit> units) {
  std::string list;
  for (const Unit& unit : units)
    if (!unit.name.empty()) list += fmt::format("{}{}", list.empty() ? "" : ", ", unit.name);
  return list;
}

Result<Value> parse_number(Kind kind, std::string_view text) {
  const auto number = base::parse_number<std::int64_t>(text);
  if (!number) return unreadable(kind, text);
  return Value(*number);
}

template <typename Enum>
Result<Value> parse_name(Kind kind, std::string_view text) {
  const auto names = names_of(kind);
  const auto found = std::ranges::find(names, text);
  if (found == names.end()) return unreadable(kind, text);
  return Value(static_cast<Enum>(found - names.begin()));
}

// A number with its unit, converted to T from its count.
template <typename T>
Result<Value> parse_measured(Kind kind, std::string_view text, std::span<const Unit> units) {
  const base::Measure read = base::read_measure(text, units);
  switch (read.error) {
    case MeasureError::kNone:
      return Value(T{read.count});
    case MeasureError::kNoNumber:
    case MeasureError::kNoUnit:
      return unreadable(kind, text);
    case MeasureError::kUnknownUnit:
      return bad(fmt::format("has the unknown unit {} in {}; known are {}", in_quotes(read.unit),
                             in_quotes(text), unit_list(units)));
    case MeasureError::kTooLarge:
      return bad(fmt::format("{} is too large", in_quotes(text)));
  }
  return unreadable(kind, text);
}

// Uniform error text: a value that cannot be parsed is answered with an example.
template <typename T>
Result<Value> parsed(Kind kind, std::string_view text, std::optional<T> value) {
  if (!value) return unreadable(kind, text);
  return Value(std::move(*value));
}

Result<Value> parse_system(std::string_view text) {
  if (text == "*") return Value(std::optional<std::uint16_t>());
  const auto number = parse_number(Kind::kSystem, text);
  if (!number) return number.error();
  const auto checked = check_range(Kind::kNumber, {0, kIdMax}, *number);
  if (!checked) return checked.error();
  return Value(std::optional(static_cast<std::uint16_t>(std::get<std::int64_t>(*number))));
}

// Exactly `count` numbers separated by slashes.
template <std::size_t count>
std::optional<std::array<std::uint8_t, count>> parse_numbers(std::string_view rest) {
  std::array<std::uint8_t, count> numbers{};
  for (std::uint8_t& each : numbers) {
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), each);
    if (error != std::errc{}) return std::nullopt;
    rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
    const bool is_last = &each == &numbers.back();
    if (is_last ? !rest.empty() : !rest.starts_with('/')) return std::nullopt;
    if (!is_last) rest.remove_prefix(1);
  }
  return numbers;
}

Result<Value> parse_classes(std::string_view text) {
  const auto from = parse_numbers<core::kClasses - 1>(text);
  if (!from) return unreadable(Kind::kClasses, text);
  const PriorityClasses classes{*from};
  if (!classes.valid()) return bad(fmt::format("{} does not ascend", in_quotes(text)));
  return Value(classes);
}

Result<Value> parse_widths(std::string_view text) {
  const auto bits = parse_numbers<4>(text);
  if (!bits) return unreadable(Kind::kWidths, text);
  const AddressWidths widths{(*bits)[0], (*bits)[1], (*bits)[2], (*bits)[3]};
  if (!widths.valid())
    return bad(fmt::format("{} does not add up to 32 bits with at least 1 for each field",
                           in_quotes(text)));
  return Value(widths);
}

Result<Value> parse_paths(std::string_view text) {
  LinkPaths paths;
  for (bool more = true; more;) {
    const std::size_t end = std::min(text.find('+'), text.size());
    const auto found = std::ranges::find(kPaths, text.substr(0, end));
    if (found == kPaths.end())
      return bad(fmt::format(R"(has the unknown path {}; known are "udp", "dds" and "tcp")",
                             in_quotes(text.substr(0, end))));
    const auto path = static_cast<PathKind>(found - kPaths.begin());
    if (std::ranges::find(paths, path) != paths.end())
      return bad(fmt::format("has {} twice", in_quotes(*found)));
    paths.push_back(path);
    more = end < text.size();
    if (more) text.remove_prefix(end + 1);
  }
  return Value(paths);
}

// Parses the text without checking limits.
Result<Value> parse_any(Kind kind, std::string_view text) {
  switch (kind) {
    case Kind::kText:
      return Value(std::string(text));
    case Kind::kFlag:
      if (text != "true" && text != "false") return unreadable(kind, text);
      return Value(text == "true");
    case Kind::kNumber:
      return parse_number(kind, text);
    case Kind::kDuration:
      return parse_measured<Duration>(kind, text, kDurationUnits);
    case Kind::kSize:
      return parse_measured<Bytes>(kind, text, kSizeUnitsRead);
    case Kind::kEndpoint:
      if (text == "off") return Value(std::optional<Endpoint>());
      return parsed(kind, text, Endpoint::parse(text));
    case Kind::kLogLevel:
      return parse_name<LogLevel>(kind, text);
    case Kind::kRole:
      return parse_name<Role>(kind, text);
    case Kind::kLinkKind:
      return parse_name<LinkKind>(kind, text);
    case Kind::kDestination:
      return parsed(kind, text, Destination::parse(text));
    case Kind::kSystem:
      return parse_system(text);
    case Kind::kRate:
      return parse_measured<Rate>(kind, text, kSizeUnitsRead);
    case Kind::kWidths:
      return parse_widths(text);
    case Kind::kPaths:
      return parse_paths(text);
    case Kind::kClasses:
      return parse_classes(text);
    case Kind::kCompression:
      return parse_name<Compression>(kind, text);
  }
  return unreadable(kind, text);
}

// The quantity that the range limits; empty for kinds without range.
std::optional<std::int64_t> measure(const Value& value) {
  if (const auto* text = std::get_if<std::string>(&value))
    return static_cast<std::int64_t>(text->size());
  if (const auto* number = std::get_if<std::int64_t>(&value)) return *number;
  if (const auto* duration = std::get_if<Duration>(&value)) return duration->count();
  if (const auto* bytes = std::get_if<Bytes>(&value)) return bytes->count;
  if (const auto* rate = std::get_if<Rate>(&value)) return rate->bytes_per_second;
  return std::nullopt;
}

std::string measure_text(Kind kind, std::int64_t measure) {
  if (kind == Kind::kDuration) return base::exact_text(measure, kDurationUnits);
  if (kind == Kind::kSize) return base::exact_text(measure, kSizeUnits);
  if (kind == Kind::kRate) return base::exact_text(measure, kRateUnits);
  return std::to_string(measure);
}

// ASCII only: other bytes are part of a multi-byte character.
bool is_control(char c) {
  const auto code = static_cast<unsigned char>(c);
  return code < 0x80 && base::is_control(code);
}

// Escapes "$" as "$$", so that loading the text substitutes nothing.
std::string without_substitution(std::string_view text) {
  std::string out;
  for (const char c : text) out.append(c == '$' ? 2 : 1, c);
  return out;
}

// to_toml for each alternative of Value.
struct ToToml {
  std::string operator()(const std::string& text) const {
    return in_quotes(without_substitution(text));
  }
  std::string operator()(bool flag) const { return flag ? "true" : "false"; }
  std::string operator()(std::int64_t number) const { return std::to_string(number); }
  std::string operator()(Duration duration) const {
    return in_quotes(measure_text(Kind::kDuration, duration.count()));
  }
  std::string operator()(Bytes bytes) const {
    return in_quotes(measure_text(Kind::kSize, bytes.count));
  }
  std::string operator()(Rate rate) const {
    return in_quotes(measure_text(Kind::kRate, rate.bytes_per_second));
  }
  std::string operator()(const std::optional<Endpoint>& endpoint) const {
    return in_quotes(endpoint ? endpoint->to_string() : "off");
  }
  std::string operator()(const Destination& to) const { return in_quotes(to.to_string()); }
  std::string operator()(LogLevel level) const { return name(Kind::kLogLevel, level); }
  std::string operator()(Role role) const { return name(Kind::kRole, role); }
  std::string operator()(LinkKind kind) const { return name(Kind::kLinkKind, kind); }
  std::string operator()(std::optional<std::uint16_t> system) const {
    return system ? std::to_string(*system) : in_quotes("*");
  }
  std::string operator()(const AddressWidths& w) const {
    return fmt::format("\"{}/{}/{}/{}\"", w.system, w.class_id, w.instance, w.local);
  }
  std::string operator()(const PriorityClasses& classes) const {
    return in_quotes(classes.to_string());
  }
  std::string operator()(Compression compression) const {
    return name(Kind::kCompression, compression);
  }
  std::string operator()(const LinkPaths& paths) const {
    std::string list;
    for (const PathKind path : paths)
      list.append(list.empty() ? "" : ", ")
          .append(in_quotes(kPaths[static_cast<std::size_t>(path)]));
    return "[" + list + "]";
  }

  template <typename Enum>
  static std::string name(Kind kind, Enum value) {
    return in_quotes(names_of(kind)[static_cast<std::size_t>(value)]);
  }
};

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
  if (kind == Kind::kRate && size == 0) return {};
  if (!size || (*size >= range.min && *size <= range.max)) return {};
  return bad(fmt::format("{} is out of range ({})",
                         text != nullptr ? in_quotes(*text) : measure_text(kind, *size),
                         range_text(kind, range)));
}

std::string to_toml(const Value& value) { return std::visit(ToToml{}, value); }

std::string_view kind_name(Kind kind) {
  static constexpr std::array<std::string_view, 16> kNames{"text",
                                                           "true or false",
                                                           "number",
                                                           "duration",
                                                           "size",
                                                           "address:port or off",
                                                           "level",
                                                           "role",
                                                           "kind",
                                                           "host:port",
                                                           "number or \"*\"",
                                                           "bytes per second",
                                                           "bits of system/class/instance/local",
                                                           "list of paths",
                                                           "seven priorities",
                                                           "compression"};
  return kNames.at(static_cast<std::size_t>(kind));
}

std::string_view kind_example(Kind kind) {
  static constexpr std::array<std::string_view, 16> kExamples{
      R"(a text such as "robot1")",
      "true or false",
      "a whole number",
      R"(a duration with its unit such as "250ms" or "5s")",
      R"(a size such as "4MiB" or 262144 (bytes))",
      R"(a numeric address and port such as "127.0.0.1:2000", "0.0.0.0:2000" (all interfaces))"
      R"( or "[::1]:2000", or "off")",
      R"("error", "warning", "info" or "debug")",
      R"("subsystem", "system" or "top")",
      R"("super", "peer" or "sub")",
      R"(a host and port such as "10.9.1.1:2010", "robot1:2010" or "[fd00::1]:2010")",
      R"(a system's number or "*" for any)",
      R"(a rate such as "6MB" (bytes per second) or 0 for no limit)",
      R"(four bit widths such as "8/8/8/8")",
      R"(a list of paths such as ["udp", "dds"])",
      R"(seven priorities from 0 to 255 that ascend, such as "0/1/15/25/35/45/100")",
      R"("auto", "off", "lz4" or "zstd")"};
  return kExamples.at(static_cast<std::size_t>(kind));
}

std::string range_text(Kind kind, Range range) {
  if (const auto names = names_of(kind); !names.empty())
    return fmt::format("{}", fmt::join(names, ", "));
  switch (kind) {
    case Kind::kText:
    case Kind::kNumber:
    case Kind::kDuration:
    case Kind::kSize:
    case Kind::kRate:
      break;
    default:
      return {};
  }
  const std::string ends =
      fmt::format("{} to {}", measure_text(kind, range.min), measure_text(kind, range.max));
  if (kind == Kind::kText) return ends + " bytes long";
  return kind == Kind::kRate ? ends + ", or 0" : ends;
}

}  // namespace tims::config
