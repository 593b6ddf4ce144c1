#include "tools/cli/arguments.h"

#include <ranges>

#include <fmt/format.h>

#include "base/text.h"
#include "tims/message.h"
#include "tools/cli/failure.h"

namespace timsctl {

namespace {

struct TypeName {
  std::int8_t type;
  std::string_view name;
};
// Types between tools and routers, and types common to all classes; the catalogue has the others.
constexpr TypeName kOtherNames[] = {{tims::type::kData, "data"},
                                    {tims::type::kAdminRequest, "admin_request"},
                                    {tims::type::kAdminReply, "admin_reply"}};

// Converts "Ladar/3/0:2" to "Ladar(3/0):2"; other texts are unchanged.
std::string with_parentheses(std::string_view text) {
  const std::size_t first = text.find('/');
  if (first == std::string_view::npos || text.find('(') != std::string_view::npos)
    return std::string(text);
  const std::string_view rest = text.substr(first + 1);
  const std::size_t end = std::min(rest.find(':'), rest.size());
  return fmt::format("{}({}){}", text.substr(0, first), rest.substr(0, end), rest.substr(end));
}

// Suggests "Ladar/3/0" for "Ladr/3/0" if only the class is unknown.
std::string hint_for(std::string_view text, std::string otherwise) {
  const std::string_view name = text.substr(0, text.find_first_of("(/"));
  if (name.empty() || tims::class_id_of(name)) return otherwise;
  std::vector<std::string> known;
  for (std::uint32_t id = 0; id <= 0xFF; ++id)
    if (!tims::class_name(id).empty()) known.emplace_back(base::lower(tims::class_name(id)));
  const auto near = base::nearest(base::lower(name), known);
  if (!near) return otherwise;
  return fmt::format("did you mean {}{}?", tims::class_name(*tims::class_id_of(*near)),
                     text.substr(name.size()));
}

}  // namespace

std::optional<std::int8_t> parse_type(std::string_view text, std::uint32_t class_id) {
  for (const TypeName& known : kOtherNames)
    if (known.name == text) return known.type;
  if (const auto* known = rack::find_message(class_id, text)) return known->type;
  const auto number = base::parse_number<int>(text);
  if (!number || *number < -128 || *number > 127) return std::nullopt;
  return static_cast<std::int8_t>(*number);
}

std::string type_name(std::int8_t type) {
  for (const TypeName& known : kOtherNames)
    if (known.type == type) return std::string(known.name);
  const auto* known = rack::find_message(rack::kEveryClass, type);
  return known == nullptr ? "" : base::lower(known->name);
}

std::string type_name(const tims::Header& header, const tims::AddressWidths& widths) {
  const auto* known = rack::find_message(header, widths);
  return known == nullptr ? type_name(header.type) : base::lower(known->name);
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
  const std::string text = fmt::format("{}/{}/{}", name, fields.system, fields.instance);
  return fields.local == 0 ? text : fmt::format("{}:{}", text, fields.local);
}

std::uint32_t need_class(std::string_view text) {
  const std::string_view name = text.substr(0, text.find_first_of("(/"));
  if (const auto id = tims::class_id_of(name)) return *id;
  throw usage_error(
      fmt::format("\"{}\" is not a class", text),
      hint_for(text, "such as Chassis; `timsctl msg types` shows those with messages"));
}

tims::Address need_address(std::string_view text, const tims::AddressWidths& widths) {
  if (const auto address = parse_address(text, widths)) return *address;
  if (parse_pattern(text, widths))
    throw usage_error(
        fmt::format("\"{}\" is a pattern; a single address is required", text),
        fmt::format("`timsctl component list '{}'` lists the matching addresses", text));
  throw usage_error(fmt::format("\"{}\" is not an address", text),
                    hint_for(text, "Ladar/3/0, 'Ladar(3/0):2' or 0x03140002"));
}

std::vector<tims::Address> need_addresses(const std::vector<std::string>& texts,
                                          const tims::AddressWidths& widths) {
  std::vector<tims::Address> addresses;
  addresses.reserve(texts.size());
  for (const std::string& text : texts) addresses.push_back(need_address(text, widths));
  return addresses;
}

tims::AddressPattern need_pattern(std::string_view text, const tims::AddressWidths& widths) {
  if (const auto pattern = parse_pattern(text, widths)) return *pattern;
  throw usage_error(fmt::format("\"{}\" is not an address pattern", text),
                    hint_for(text, "Ladar, 'Ladar(*/0)', '*/3/0' or 0x03140000"));
}

std::vector<std::string_view> parts_of(std::string_view text, char between) {
  std::vector<std::string_view> parts;
  for (const auto part : std::views::split(text, between))
    parts.emplace_back(part.begin(), part.end());
  return parts;
}

json::object address_json(tims::Address address, const tims::AddressWidths& widths) {
  return {{"name", address.to_string(widths)}, {"raw", address.to_hex()}};
}

}  // namespace timsctl
