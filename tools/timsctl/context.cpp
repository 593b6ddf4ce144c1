#include "tools/timsctl/context.h"

#include "os/clock.h"
#include "router/config/nearest.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/fleet.h"
#include "tools/timsctl/message_fields.h"
#include "tools/timsctl/values.h"

namespace timsctl {

tims::Time Context::run_end() const {
  return options.run_for ? tims::os::deadline_after(*options.run_for) : tims::kNever;
}

std::unique_ptr<Connection> Context::connect(const MailboxWish& wish) const {
  if (const auto* tcp = std::get_if<TcpHost>(&host))
    return connect_tcp(*tcp, wish, options.timeout);
  // Called from the session's own thread; it writes one line to stderr.
  const Log log = [this](const std::string& text) { out.detail(text); };
  return connect_local(std::get<UnixHost>(host), wish, options.timeout, log);
}

AdminClient Context::admin(Connection& connection) const {
  const AdminClient here(connection, signals, options.timeout);
  if (options.router.empty()) return here;
  return here.at(find_router(here, options.router));
}

namespace {

// "Ladr/3/0" was meant to be "Ladar/3/0"; nothing when the class is not what is wrong.
std::optional<std::string> nearest_class(std::string_view text) {
  const std::string_view name = text.substr(0, text.find_first_of("(/"));
  if (name.empty() || tims::class_id_of(name)) return std::nullopt;
  std::vector<std::string> known;
  std::vector<std::string_view> lowered;
  for (std::uint32_t id = 0; id <= 0xFF; ++id)
    if (!tims::class_name(id).empty()) known.emplace_back(lower(tims::class_name(id)));
  lowered.assign(known.begin(), known.end());
  const auto near = tims::config::nearest(lower(name), lowered);
  if (!near) return std::nullopt;
  return std::string(tims::class_name(*tims::class_id_of(*near))).append(text.substr(name.size()));
}

std::string hint_for(std::string_view text, std::string otherwise) {
  const auto near = nearest_class(text);
  return near ? "did you mean " + *near + "?" : std::move(otherwise);
}

}  // namespace

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

std::int8_t need_type(std::string_view text, std::uint32_t class_id) {
  const auto type = parse_type(text, class_id);
  return type ? *type : need_message(class_id, text).type;
}

}  // namespace timsctl
