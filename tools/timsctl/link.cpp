// timsctl link: the links of a router to others.
#include "tools/timsctl/commands.h"
#include "tools/timsctl/show.h"

namespace timsctl {

namespace {

constexpr Column kLinks[] = {
    {"PEER", "via"},
    {"KIND", "kind"},
    {"STATE", "state"},
    {"SINCE", "since_s", As::kDuration},
    {"PATH", "path"},
    {"ADDRESS", "peer_address"},
    {"RTT", "rtt_s", As::kDuration},
    {"LOSS_IN", "loss_in", As::kPercent},
    {"LOSS_OUT", "loss_out", As::kPercent},
    {"MTU", "mtu_bytes"},
    {"MAILBOXES", "mailboxes", As::kCount},
    {"IN", "in_messages", As::kCount},
    {"OUT", "out_messages", As::kCount},
    {"DROPS", "drops", As::kCount, false, true},
    {"IN_BYTES", "wire_bytes_in", As::kBytes, true},
    {"OUT_BYTES", "wire_bytes_out", As::kBytes, true},
    {"IN_FLIGHT", "in_flight_bytes", As::kBytes, true},
    {"WINDOW", "window_bytes", As::kBytes, true},
    {"QUEUE_DELAY", "queue_delay_s", As::kDuration, true},
    {"QUEUES", "queue_bytes", As::kText, true},
    {"OFFSET", "clock.offset_s", As::kDuration, true},
    {"ACTIVE", "active", As::kText, true},
    {"HEARD", "heard_s", As::kDuration, true},
    {"REFUSED", "refusal", As::kText},
};

constexpr Column kPaths[] = {
    {"PEER", "via"},
    {"PATH", "path"},
    {"USED", "used"},
    {"STATE", "state"},
    {"SINCE", "since_s", As::kDuration},
    {"ADDRESS", "peer_address"},
    {"IN", "datagrams_in", As::kCount},
    {"OUT", "datagrams_out", As::kCount},
    {"IN_BYTES", "wire_bytes_in", As::kBytes, true},
    {"OUT_BYTES", "wire_bytes_out", As::kBytes, true},
    {"WHY", "why"},
};

// The ways of a link that has a choice, one an item. Why another is used says the one in use.
void add_paths(const json::object& link, json::array& all) {
  const json::value* paths = link.if_contains("paths");
  if (paths == nullptr || !paths->is_array() || paths->get_array().size() < 2) return;
  for (const json::value& value : paths->get_array()) {
    json::object path = value.as_object();
    const bool used = path.at("used").as_bool();
    path["via"] = link.at("via");
    path["state"] = path.at("works").as_bool() ? "works" : "silent";
    if (!path.at("trouble").is_null()) path["state"] = path.at("trouble");
    path["used"] = used ? "yes" : "no";
    path["why"] = used ? link.at("path_why") : json::value();
    all.push_back(std::move(path));
  }
}

std::string draw_links(const json::object& answer, const Look& look) {
  std::string text = render_items(items_of(answer), kLinks, look);
  json::array paths;
  for (const json::value& link : items_of(answer)) add_paths(link.as_object(), paths);
  const bool people = look.format == Format::kTable || look.format == Format::kWide;
  if (!paths.empty() && people) text += "\n" + render_items(paths, kPaths, look);
  return text;
}

Exit act(Context& context, std::string_view what) {
  const auto connection = context.connect();
  AdminClient admin = context.admin(*connection);
  const json::object answer =
      admin.ask({{"ask", "link"}, {"link", context.options.arguments.front()}, {"do", what}});
  if (context.out.json()) context.out.write(answer);
  return Exit::kDone;
}

}  // namespace

Exit link_show(Context& context) {
  json::object question{{"ask", "links"}};
  if (!context.options.arguments.empty()) question["link"] = context.options.arguments.front();
  return show_items(context, question, kLinks, draw_links);
}

Exit link_up(Context& context) { return act(context, "up"); }
Exit link_down(Context& context) { return act(context, "down"); }
Exit link_reset(Context& context) { return act(context, "reset"); }

}  // namespace timsctl
