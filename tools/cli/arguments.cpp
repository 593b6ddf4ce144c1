#include "tools/cli/arguments.h"

#include <algorithm>
#include <ranges>

#include <fmt/format.h>

#include "base/text.h"
#include "proxies/message_files.h"
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

constexpr std::string_view kUnknown = "unknown[";

std::string_view class_part(std::string_view text) {
  return text.substr(0, std::min(text.find_first_of("(/*"), text.size()));
}

bool is_name(std::string_view text) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  return !text.empty() && letter(text.front()) && !text.starts_with(kUnknown);
}

// The text is a name of letters and digits, but no class has this name.
bool names_no_class(std::string_view text) {
  const std::string_view name = class_part(text);
  return is_name(name) && !tims::class_id_of(name);
}

// Suggests "Ladar/3/0" for "Ladr/3/0" if only the class is unknown.
std::string hint_for(std::string_view text, std::string otherwise) {
  if (!names_no_class(text)) return otherwise;
  const std::string_view name = class_part(text);
  std::vector<std::string> known;
  for (std::uint32_t id = 0; id <= 0xFF; ++id)
    if (!tims::class_name(id).empty()) known.emplace_back(base::lower(tims::class_name(id)));
  for (const rack::ClassInfo& own : rack::added_classes())
    known.emplace_back(base::lower(own.name));
  const auto near = base::nearest(base::lower(name), known);
  if (!near) return fmt::format("for a class of your own: {}", rack::message_places());
  return fmt::format("did you mean {}{}?", tims::class_name(*tims::class_id_of(*near)),
                     text.substr(name.size()));
}

// The names of classes that RACK does not define as numbers: a router has not read their files.
std::string with_numbers(std::string form) {
  const std::size_t end = class_part(form).size();
  const auto id = tims::class_id_of(std::string_view(form).substr(0, end));
  const auto own = rack::added_classes();
  if (!id || std::ranges::find(own, *id, &rack::ClassInfo::class_id) == own.end()) return form;
  return fmt::format("{}{:x}]{}", kUnknown, *id, std::string_view(form).substr(end));
}

// "\"Ladar/3/500\" is not an address: instance 500 is out of range ..."
std::string not_an(std::string_view what, std::string_view text,
                   const tims::AddressWidths& widths) {
  const std::string why = names_no_class(text)
                              ? fmt::format("no class is called {}", class_part(text))
                              : tims::Address::problem(with_parentheses(text), widths);
  return fmt::format("\"{}\" is not {}{}{}", text, what, why.empty() ? "" : ": ", why);
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
  const std::string_view name = text.ends_with('*') ? text.substr(0, text.size() - 1) : text;
  const bool whole = tims::class_id_of(name) || (name.starts_with(kUnknown) && name.ends_with(']'));
  return with_numbers(whole ? std::string(name).append("(*/*)") : with_parentheses(text));
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

std::string with_class_names(std::string text) {
  for (std::size_t at = text.find(kUnknown); at != std::string::npos;
       at = text.find(kUnknown, at + 1)) {
    const std::size_t begin = at + kUnknown.size();
    const std::size_t end = text.find(']', begin);
    if (end == std::string::npos) break;
    const auto id =
        base::parse_number<std::uint32_t>(std::string_view(text).substr(begin, end - begin), 16);
    if (!id) continue;
    if (const std::string_view known = tims::class_name(*id); !known.empty())
      text.replace(at, end + 1 - at, known);
  }
  return text;
}

std::uint32_t need_class(std::string_view text) {
  const std::string_view name = class_part(text);
  if (const auto id = tims::class_id_of(name)) return *id;
  constexpr tims::AddressWidths kLongClass{1, 29, 1, 1};
  if (const auto unnamed = parse_address(fmt::format("{}(0/0)", name), kLongClass))
    return unnamed->fields(kLongClass).class_id;
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
  throw usage_error(not_an("an address", text, widths),
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
  throw usage_error(not_an("an address pattern", text, widths),
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
