#include "tools/cli/arguments.h"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "base/text.h"
#include "tims/message.h"
#include "tools/cli/failure.h"

namespace timsctl {

using namespace std::chrono_literals;

namespace {

struct TypeName {
  std::int8_t type;
  std::string_view name;
};
// Between tools and routers, and what every class calls the same; the others are the catalogue's.
constexpr TypeName kOtherNames[] = {{tims::type::kData, "data"},
                                    {tims::type::kAdminRequest, "admin_request"},
                                    {tims::type::kAdminReply, "admin_reply"}};

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

// "Ladr/3/0" was meant to be "Ladar/3/0"; nothing when the class is not what is wrong.
std::optional<std::string> nearest_class(std::string_view text) {
  const std::string_view name = text.substr(0, text.find_first_of("(/"));
  if (name.empty() || tims::class_id_of(name)) return std::nullopt;
  std::vector<std::string> known;
  std::vector<std::string_view> lowered;
  for (std::uint32_t id = 0; id <= 0xFF; ++id)
    if (!tims::class_name(id).empty()) known.emplace_back(base::lower(tims::class_name(id)));
  lowered.assign(known.begin(), known.end());
  const auto near = base::nearest(base::lower(name), lowered);
  if (!near) return std::nullopt;
  return std::string(tims::class_name(*tims::class_id_of(*near))).append(text.substr(name.size()));
}

std::string hint_for(std::string_view text, std::string otherwise) {
  const auto near = nearest_class(text);
  return near ? "did you mean " + *near + "?" : std::move(otherwise);
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
  std::string text(name);
  text.append("/").append(std::to_string(fields.system));
  text.append("/").append(std::to_string(fields.instance));
  if (fields.local != 0) text.append(":").append(std::to_string(fields.local));
  return text;
}

std::uint32_t need_class(std::string_view text) {
  const std::string_view name = text.substr(0, text.find_first_of("(/"));
  if (const auto id = tims::class_id_of(name)) return *id;
  throw usage_error(
      "\"" + std::string(text) + "\" is no class",
      hint_for(text, "such as Chassis; `timsctl msg types` shows those with messages"));
}

tims::Address need_address(std::string_view text, const tims::AddressWidths& widths) {
  if (const auto address = parse_address(text, widths)) return *address;
  if (parse_pattern(text, widths))
    throw usage_error("\"" + std::string(text) + "\" is a pattern; here one address is meant",
                      "`timsctl component list '" + std::string(text) + "'` shows what it fits");
  throw usage_error("\"" + std::string(text) + "\" is no address",
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
  throw usage_error("\"" + std::string(text) + "\" is no pattern of addresses",
                    hint_for(text, "Ladar, 'Ladar(*/0)', '*/3/0' or 0x03140000"));
}

json::object address_json(tims::Address address, const tims::AddressWidths& widths) {
  return {{"name", address.to_string(widths)}, {"raw", address.to_hex()}};
}

}  // namespace timsctl
