#include "rack/codec/parse.h"

#include <algorithm>

namespace rack::parse {

namespace {

std::string quoted(std::string_view text) {
  std::string out;
  print::append_quoted(out, text);
  return out;
}

tims::Error invalid(std::string text) { return {tims::Errc::kInvalidArgument, std::move(text)}; }

}  // namespace

tims::Error no_field(std::string_view type, std::string_view path) {
  return invalid(std::string(type).append(" has no field ").append(quoted(path)));
}

tims::Error bad_value(const Assignment& a, std::string_view wanted) {
  return invalid(
      std::string(a.field).append("=").append(a.value).append(": wanted is ").append(wanted));
}

tims::Error bad_number(const Assignment& a, std::string_view unit) {
  return bad_value(a, std::string("a number").append(unit.empty() ? "" : " in ").append(unit));
}

tims::Error bad_whole(const Assignment& a, i64 min, std::uint64_t max) {
  return bad_value(a, "a whole number from " + std::to_string(min) + " to " + std::to_string(max));
}

tims::Error bad_index(const Assignment& a, std::size_t there, std::size_t max) {
  return invalid(std::string(a.field) + ": an index is wanted, here up to " +
                 std::to_string(std::min(there, max - 1)) + "; elements are set in their order");
}

std::string_view take_name(std::string_view& path) {
  const std::string_view name = path.substr(0, path.find_first_of(".["));
  path.remove_prefix(name.size());
  return name;
}

std::optional<std::size_t> take_index(std::string_view& path) {
  const std::size_t end = path.find(']');
  if (!path.starts_with('[') || end == std::string_view::npos) return std::nullopt;
  const auto index = number<std::size_t>(path.substr(1, end - 1));
  path.remove_prefix(end + 1);
  return index;
}

std::optional<std::string> bytes_of(std::string_view digits) {
  std::string out;
  for (; !digits.empty(); digits.remove_prefix(2)) {
    unsigned value = 0;
    if (digits.size() < 2) return std::nullopt;
    const auto [stop, error] = std::from_chars(digits.data(), digits.data() + 2, value, 16);
    if (error != std::errc() || stop != digits.data() + 2) return std::nullopt;
    out += static_cast<char>(value);
  }
  return out;
}

std::optional<Measure> measure(std::string_view text, std::string_view unit,
                               std::string_view si_unit, bool si) {
  f64 ignored = 0;
  const char* const end = text.data() + text.size();
  const auto stop = std::from_chars(text.data(), end, ignored).ptr;
  const auto size = static_cast<std::size_t>(stop - text.data());
  std::string_view behind = text.substr(size);
  while (behind.starts_with(' ')) behind.remove_prefix(1);
  const std::string_view digits = text.substr(0, size);
  if (behind.empty()) return Measure{digits, si};
  if (behind == unit) return Measure{digits, false};
  if (behind == si_unit) return Measure{digits, true};
  return std::nullopt;
}

}  // namespace rack::parse
