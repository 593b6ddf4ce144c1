#include "tools/timsctl/values.h"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "tims/message.h"

namespace timsctl {

using namespace std::chrono_literals;

namespace {

struct Unit {
  std::string_view name;
  double factor;
};

constexpr Unit kTimeUnits[] = {{"", 1e9},  {"ns", 1},   {"us", 1e3},   {"ms", 1e6},
                               {"s", 1e9}, {"m", 60e9}, {"min", 60e9}, {"h", 3600e9}};
constexpr Unit kSizeUnits[] = {{"", 1},     {"B", 1},        {"kB", 1e3},     {"MB", 1e6},
                               {"GB", 1e9}, {"KiB", 0x1p10}, {"MiB", 0x1p20}, {"GiB", 0x1p30}};

struct TypeName {
  std::int8_t type;
  std::string_view name;
};
// Between tools and routers, and what every class calls the same; the others are the catalogue's.
constexpr TypeName kOtherNames[] = {{tims::type::kData, "data"},
                                    {tims::type::kAdminRequest, "admin_request"},
                                    {tims::type::kAdminReply, "admin_reply"}};

template <typename T>
std::optional<T> parse_number(std::string_view text) {
  T value{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (text.empty() || error != std::errc() || stop != end) return std::nullopt;
  return value;
}

// A number that is not negative and its unit.
std::optional<double> parse_measure(std::string_view text, std::span<const Unit> units) {
  std::size_t digits = text.find_first_not_of("0123456789.");
  if (digits == std::string_view::npos) digits = text.size();
  const auto number = parse_number<double>(text.substr(0, digits));
  if (!number || !std::isfinite(*number)) return std::nullopt;
  for (const Unit& unit : units)
    if (unit.name == text.substr(digits)) return *number * unit.factor;
  return std::nullopt;
}

// "Ladar/3/0:2" as "Ladar(3/0):2"; anything else stays.
std::string with_parentheses(std::string_view text) {
  const std::size_t first = text.find('/');
  if (first == std::string_view::npos || text.find('(') != std::string_view::npos)
    return std::string(text);
  std::string out(text.substr(0, first));
  const std::string_view rest = text.substr(first + 1);
  const std::size_t colon = rest.find(':');
  out.append("(").append(rest.substr(0, colon)).append(")");
  if (colon != std::string_view::npos) out.append(rest.substr(colon));
  return out;
}

}  // namespace

std::optional<tims::Duration> parse_duration(std::string_view text) {
  const auto ns = parse_measure(text, kTimeUnits);
  if (!ns || *ns > 1e18) return std::nullopt;
  return tims::Duration(std::llround(*ns));
}

std::optional<std::uint32_t> parse_size(std::string_view text) {
  const auto bytes = parse_measure(text, kSizeUnits);
  if (!bytes || *bytes > std::numeric_limits<std::uint32_t>::max()) return std::nullopt;
  return static_cast<std::uint32_t>(*bytes);
}

std::optional<std::uint64_t> parse_count(std::string_view text) {
  return parse_number<std::uint64_t>(text);
}

std::optional<std::int8_t> parse_type(std::string_view text, std::uint32_t class_id) {
  for (const TypeName& known : kOtherNames)
    if (known.name == text) return known.type;
  if (const auto* known = rack::find_message(class_id, text)) return known->type;
  const auto number = parse_number<int>(text);
  if (!number || *number < -128 || *number > 127) return std::nullopt;
  return static_cast<std::int8_t>(*number);
}

std::string type_name(std::int8_t type) {
  for (const TypeName& known : kOtherNames)
    if (known.type == type) return std::string(known.name);
  const auto* known = rack::find_message(rack::kEveryClass, type);
  return known == nullptr ? "" : lower(known->name);
}

std::string type_name(const tims::Header& header, const tims::AddressWidths& widths) {
  const auto* known = rack::find_message(header, widths);
  return known == nullptr ? type_name(header.type) : lower(known->name);
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c | 0x20);
  return out;
}

std::optional<tims::Address> parse_address(std::string_view text,
                                           const tims::AddressWidths& widths) {
  return tims::Address::parse(with_parentheses(text), widths);
}

std::string pattern_text(std::string_view text) {
  const std::string_view class_part = text.ends_with('*') ? text.substr(0, text.size() - 1) : text;
  if (tims::class_id_of(class_part)) return std::string(class_part).append("(*/*)");
  return with_parentheses(text);
}

std::optional<tims::AddressPattern> parse_pattern(std::string_view text,
                                                  const tims::AddressWidths& widths) {
  return tims::AddressPattern::parse(pattern_text(text), widths);
}

std::string shell_name(tims::Address address, const tims::AddressWidths& widths) {
  const auto fields = address.fields(widths);
  const std::string_view name = tims::class_name(fields.class_id);
  if (name.empty()) return address.to_hex();
  std::string text(name);
  text.append("/").append(std::to_string(fields.system));
  text.append("/").append(std::to_string(fields.instance));
  if (fields.local != 0) text.append(":").append(std::to_string(fields.local));
  return text;
}

std::optional<std::vector<std::byte>> parse_hex(std::string_view text) {
  std::vector<std::byte> bytes;
  while (!text.empty()) {
    if (text.starts_with(' ') || text.starts_with(':') || text.starts_with('\n')) {
      text.remove_prefix(1);
      continue;
    }
    if (text.starts_with("0x")) text.remove_prefix(2);
    unsigned value = 0;
    if (text.size() < 2) return std::nullopt;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + 2, value, 16);
    if (error != std::errc() || stop != text.data() + 2) return std::nullopt;
    bytes.push_back(static_cast<std::byte>(value));
    text.remove_prefix(2);
  }
  return bytes;
}

std::string to_hex(std::span<const std::byte> bytes) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  text.reserve(2 * bytes.size());
  for (const std::byte b : bytes) {
    text += kDigits[std::to_integer<unsigned>(b) >> 4];
    text += kDigits[std::to_integer<unsigned>(b) & 0xF];
  }
  return text;
}

}  // namespace timsctl
