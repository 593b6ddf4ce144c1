// timsctl router: who the router is, and who is attached to it.
#include <csignal>

#include <fmt/format.h>

#include "router/config/config.h"
#include "tools/cli/admin_client.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/cli/service.h"
#include "tools/timsctl/verbs.h"

namespace timsctl {

namespace {

constexpr Column kIdentity[] = {
    {"Name", "name"},
    {"Address", "address.name"},
    {"Raw address", "address.raw"},
    {"Version", "version"},
    {"Pid", "pid"},
    {"Epoch", "epoch"},
    {"Up", "uptime_s", As::kDuration},
    {"Unix socket", "listen.unix"},
    {"TCP", "listen.tcp"},
    {"HTTP", "listen.http"},
    {"UDP", "listen.udp"},
    {"Memory", "rss_bytes", As::kBytes},
    {"Of it, table", "table_bytes", As::kBytes},
    {"Longest turn", "longest_turn_s", As::kDuration},
};

constexpr Column kFleet[] = {
    {"ROUTER", "tree"},
    {"ROLE", "role"},
    {"SYSTEM", "system"},
    {"ID", "id"},
    {"ADDRESS", "address.name", As::kText, true},
    {"STATE", "state"},
    {"SINCE", "since_s", As::kDuration},
    {"RTT", "rtt_s", As::kDuration},
    {"CLOCK", "clock.offset_s", As::kDuration},
    {"VERSION", "version", As::kText, true},
    {"EPOCH", "epoch", As::kText, true},
};

constexpr Column kClocks[] = {
    {"ROUTER", "name"},
    {"OFFSET", "clock.offset_s", As::kDuration},
    {"WITHIN", "clock.uncertainty_s", As::kDuration},
    {"RTT", "rtt_s", As::kDuration},
    {"STATE", "state"},
};

// The highest routers first, below each those it leads.
class Tree {
 public:
  explicit Tree(json::array& items) : items_(items) {}

  json::array run() {
    for (const std::string_view role : {"top", "system", "subsystem"}) {
      for (json::value& item : items_)
        if (item.is_object() && text_at(item.as_object(), "role") == role) place(item, 0);
    }
    for (json::value& item : items_) place(item, 0);  // of a role we do not know
    return std::move(out_);
  }

 private:
  void place(json::value& value, int depth) {
    if (value.is_null()) return;
    json::object item = value.as_object();
    value = nullptr;
    const std::string name = text_at(item, "name");
    item["tree"] = std::string(static_cast<std::size_t>(2 * depth), ' ') + name;
    const std::string role = text_at(item, "role");
    const double system = number_or_zero(item, "system");
    out_.push_back(std::move(item));
    for (json::value& other : items_) {
      if (other.is_null()) continue;
      const json::object& below = other.as_object();
      const std::string its_role = text_at(below, "role");
      const bool lower = (role == "top" && its_role == "system") ||
                         (role == "system" && its_role == "subsystem" &&
                          number_or_zero(below, "system") == system) ||
                         (its_role.empty() && text_at(below, "parent") == name);  // it is missing
      if (lower) place(other, depth + 1);
    }
  }

  json::array& items_;
  json::array out_;
};

json::object fleet(AdminClient& admin) {
  json::object answer = walk_fleet(admin);
  answer["items"] = Tree(items_of(answer)).run();
  return answer;
}

constexpr Column kClients[] = {
    {"CLIENT", "id"},
    {"NAME", "name"},
    {"PORT", "port"},
    {"PID", "pid"},
    {"UID", "uid", As::kText, true},
    {"PEER", "peer"},
    {"SINCE", "connected_s", As::kDuration},
    {"MAILBOXES", "mailboxes", As::kCount},
    {"IN", "in_messages", As::kCount},
    {"IN_BYTES", "in_bytes", As::kBytes},
    {"OUT", "out_messages", As::kCount},
    {"OUT_BYTES", "out_bytes", As::kBytes},
    {"DROPS", "drops", As::kCount, false, true},
    {"QUEUE", "queue_bytes", As::kBytes},
};

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

constexpr tims::Duration kServerEnds = std::chrono::seconds(5);  // once it was told to

constexpr Column kDds[] = {
    {"Fleet", "fleet"},
    {"DDS", "dds.state"},
    {"Trouble", "dds.trouble"},
    {"DDS address", "dds.address"},
    {"Datagrams in", "dds.datagrams_in", As::kCount},
    {"Datagrams out", "dds.datagrams_out", As::kCount},
    {"Strange", "dds.strange", As::kCount, false, true},
    {"No room", "dds.refused", As::kCount, false, true},
    {"Nobody there", "dds.unmatched", As::kCount, false, true},
    {"Waiting", "dds.waiting_bytes", As::kBytes},
};

constexpr Column kRouters[] = {
    {"ROUTER", "name"},   {"ROLE", "role"},
    {"SYSTEM", "system"}, {"ID", "id"},
    {"LINKED", "linked"}, {"UDP", "udp"},
    {"DDS", "dds"},       {"EPOCH", "epoch", As::kText, true},
};

// Several addresses as one text.
json::array with_texts(std::span<const json::value> items) {
  json::array out;
  for (const json::value& value : items) {
    json::object item = value.as_object();
    std::string text;
    for (const json::value& address : item.at("udp").as_array())
      text.append(text.empty() ? "" : " ").append(address.as_string());
    item["udp"] = text;
    out.push_back(std::move(item));
  }
  return out;
}

std::string draw(const json::object& answer, const Look& look) {
  std::string routers = render_items(with_texts(items_of(answer)), kRouters, look);
  const bool people = look.format == Format::kTable || look.format == Format::kWide;
  if (!people) return routers;
  if (text_at(answer, "fleet").empty())
    return "this router is in no fleet: write name = \"...\" under [fleet] of its configuration\n";
  return render_page(answer, kDds, look) + "\n" + routers;
}

}  // namespace

Exit router_show(Context& context) {
  return show(
      context,
      [](AdminClient& admin) {
        return admin.ask({{"ask", "status"}});
      },
      [](const json::object& answer, const Look& look) {
        return render_page(answer, kIdentity, look);
      });
}

Exit router_list(Context& context) {
  return show(context, fleet, [](const json::object& answer, const Look& look) {
    return render_items(items_of(answer), kFleet, look);
  });
}

Exit clock(Context& context) {
  return show(context, fleet, [](const json::object& answer, const Look& look) {
    return render_items(items_of(answer), kClocks, look);
  });
}

Exit router_clients(Context& context) {
  return show_items(context, {{"ask", "clients"}}, kClients);
}

// --- timsctl link: the links of a router to others.

Exit link_show(Context& context) {
  json::object question{{"ask", "links"}};
  if (!context.options.arguments.empty()) question["link"] = context.options.arguments.front();
  return show_items(context, question, kLinks, draw_links);
}

Exit link_up(Context& context) { return act(context, "up"); }
Exit link_down(Context& context) { return act(context, "down"); }
Exit link_reset(Context& context) { return act(context, "reset"); }

// --- timsctl fleet: routers that find each other by the name of their fleet.

Exit fleet_show(Context& context) {
  return show_items(context, {{"ask", "fleet"}}, kRouters, draw);
}

// Only Ctrl-C ends the server well: after another signal it leaves files of shared memory behind.
Exit fleet_server(Context& context) {
  const auto& arguments = context.options.arguments;
  const std::string where = arguments.empty() ? "0.0.0.0:11811" : arguments.front();
  const auto endpoint = tims::config::Endpoint::parse(where);
  if (!endpoint || endpoint->port == 0)
    throw usage_error(fmt::format("\"{}\" is not a numeric address and port", where),
                      "timsctl fleet server 10.9.1.1:11811");
  const Process server = start({.command = {"fast-discovery-server", "-i", "0", "-l",
                                            endpoint->host, "-p", std::to_string(endpoint->port)}});
  try {
    (void)context.signals.wait(server.descriptor(), tims::kNever);
  } catch (const Interrupted&) {
    server.signal_group(SIGINT);
    if (!server.has_ended(kServerEnds)) server.signal_group(SIGKILL);
  }
  return server.reap().success() ? Exit::kDone : Exit::kNo;
}

}  // namespace timsctl
