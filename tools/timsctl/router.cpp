// timsctl status, router, clock, link, fleet, mbx, stats and config show: the state of a router.

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <iterator>
#include <set>

#include <fmt/format.h>
#include <unistd.h>

#include "base/measure.h"
#include "base/text.h"
#include "os/environment.h"
#include "router/config/config.h"
#include "router/config/load.h"
#include "tools/cli/admin_client.h"
#include "tools/cli/arguments.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/cli/service.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/doctor.h"

namespace timsctl {

// --- timsctl status: the summary

namespace {

std::string listening(const json::object& status) {
  std::string text;
  for (const char* port : {"unix", "tcp", "http"}) {
    const std::string where = text_at(status, fmt::format("listen.{}", port));
    if (!where.empty()) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", port, where);
  }
  return base::printable(text);
}

std::string drops_line(const json::object& status, const Look& look) {
  const double now = number_or_zero(status, "drops_last_minute");
  const std::string text =
      fmt::format("{} in the last minute, {} since the start", base::human_count(now),
                  base::human_count(number_or_zero(status, "drops")));
  const std::string to = text_at(status, "dropped_to");
  const std::string whole = to.empty() ? text : text + ": " + to;
  return now == 0 ? whole
                  : paint(whole, Tone::kBad, look.colour) + "   -> timsctl stats --by reason";
}

// "2 up; base is silent since 12 s"
std::string links_line(const json::object& status, const Look& look) {
  std::string text = fmt::format("{:.0f} up", number_or_zero(status, "links_up"));
  for (const json::object& link : objects(items_of(status, "links_not_up")))
    text += paint(
        fmt::format("; {} is {} since {}", base::printable(text_at(link, "via")),
                    text_at(link, "state"), base::human_duration(number_or_zero(link, "since_s"))),
        Tone::kBad, look.colour);
  return items_of(status, "links_not_up").empty() ? text : text + "   -> timsctl link show";
}

std::string event_lines(const json::object& status, const Look& look) {
  std::string text;
  for (const json::object& event : objects(items_of(status, "events"))) {
    const std::string time = text_at(event, "time");
    text += fmt::format("  {}  {}\n", paint(local_time(time, look.utc), Tone::kDim, look.colour),
                        base::printable(text_at(event, "text")));
  }
  return text;
}

std::string draw_status(const json::object& status, const Look& look) {
  const auto line = [&](std::string_view title, const std::string& text) {
    return fmt::format("  {} {}\n", paint(fmt::format("{:<10}", title), Tone::kDim, look.colour),
                       text);
  };
  const auto count = [&](std::string_view path) {
    return base::human_count(number_or_zero(status, path));
  };
  std::string text =
      fmt::format("{} {}, tims-router {}\n", paint("*", Tone::kGood, look.colour),
                  paint(base::printable(text_at(status, "name")), Tone::kBold, look.colour),
                  base::printable(text_at(status, "version")));
  text += line("Address", fmt::format("{}  {}", text_at(status, "address.name"),
                                      text_at(status, "address.raw")));
  text += line("Running", fmt::format("{}, pid {}, epoch {}",
                                      base::human_duration(number_or_zero(status, "uptime_s")),
                                      text_at(status, "pid"), text_at(status, "epoch")));
  text += line("Listens", listening(status));
  text += line("Carries",
               fmt::format("{} clients, {} mailboxes", count("clients"), count("mailboxes")));
  text += line("Forwarded",
               fmt::format("{} messages, {}; local ones bypass the router", count("messages"),
                           base::human_bytes(number_or_zero(status, "bytes"))));
  text += line("Dropped", drops_line(status, look));
  if (status.contains("links_up")) text += line("Links", links_line(status, look));
  text +=
      line("Memory", fmt::format("{}, longest turn {}",
                                 base::human_bytes(number_or_zero(status, "rss_bytes")),
                                 base::human_duration(number_or_zero(status, "longest_turn_s"))));
  const std::string events = event_lines(status, look);
  return events.empty() ? text : text + "\n" + events;
}

constexpr double kEventsAsked = 200;
constexpr std::ptrdiff_t kEventsShown = 5;

// The ids of command-line tools among the clients in the events.
std::set<std::string> tools_in(const json::array& events, const tims::AddressWidths& widths) {
  std::set<std::string> tools;
  for (const json::object& event : objects(events)) {
    const auto address = tims::Address::parse(text_at(event, "address.raw"));
    if (address && address->fields(widths).class_id == tims::class_id::kTool)
      tools.insert(text_at(event, "client.client"));
  }
  return tools;
}

// The last events, without those caused by requests of command-line tools.
json::array foreign_events(AdminClient& admin, double last) {
  const auto since = static_cast<std::int64_t>(std::max(0.0, last - kEventsAsked));
  json::object answer = admin.ask({{"ask", "events"}, {"since", since}});
  json::array& events = item_array(answer);
  const auto tools = tools_in(events, admin.widths());
  json::array out;
  for (json::value& event : events)
    if (!tools.contains(text_at(event.as_object(), "client.client")))
      out.push_back(std::move(event));
  if (std::ssize(out) > kEventsShown) out.erase(out.begin(), out.end() - kEventsShown);
  return out;
}

// Routers without links have nothing to report.
void add_links(AdminClient& admin, json::object& status) {
  const json::object answer = admin.ask({{"ask", "links"}});
  if (items_of(answer).empty()) return;
  json::array not_up;
  double up = 0;
  for (const json::object& link : objects(items_of(answer))) {
    if (text_at(link, "state") == "up") {
      ++up;
      continue;
    }
    not_up.push_back({{"via", text_at(link, "via")},
                      {"state", text_at(link, "state")},
                      {"since_s", number_or_zero(link, "since_s")}});
  }
  status["links_up"] = up;
  status["links_not_up"] = std::move(not_up);
}

json::object ask_status(AdminClient& admin) {
  json::object status = admin.ask({{"ask", "status"}});
  add_links(admin, status);
  status["events"] = foreign_events(admin, number_or_zero(status, "last_event"));
  if (number_or_zero(status, "drops") > 0) {
    const json::object clients = admin.ask({{"ask", "clients"}});
    if (const std::string to = lost_to(items_of(clients), {}); !to.empty())
      status["dropped_to"] = to;
  }
  return status;
}

constexpr Column kStatus[] = {
    {"ROUTER", "name"},
    {"ADDRESS", "address.name"},
    {"VERSION", "version"},
    {"PID", "pid"},
    {"UP", "uptime_s", Cell::kDuration},
    {"CLIENTS", "clients", Cell::kCount},
    {"MAILBOXES", "mailboxes", Cell::kCount},
    {"MESSAGES", "messages", Cell::kCount},
    {"BYTES", "bytes", Cell::kBytes},
    {"DROPS", "drops", Cell::kCount, false, true},
    {"DROPS/MIN", "drops_last_minute", Cell::kCount, false, true},
};

}  // namespace

Exit status(Context& context) {
  return show(context, ask_status, [](const json::object& answer, const Look& look) {
    if (look.for_people()) return draw_status(answer, look);
    const json::value item(answer);
    return render_items({&item, 1}, kStatus, look);
  });
}

// --- timsctl router: the identity of the router, and its clients

namespace {

constexpr Column kIdentity[] = {
    {"Name", "name"},
    {"Address", "address.name"},
    {"Raw address", "address.raw"},
    {"Version", "version"},
    {"Pid", "pid"},
    {"Epoch", "epoch"},
    {"Up", "uptime_s", Cell::kDuration},
    {"Unix socket", "listen.unix"},
    {"TCP", "listen.tcp"},
    {"HTTP", "listen.http"},
    {"UDP", "listen.udp"},
    {"Memory", "rss_bytes", Cell::kBytes},
    {"Routing table", "table_bytes", Cell::kBytes},
    {"Longest turn", "longest_turn_s", Cell::kDuration},
};

constexpr Column kFleet[] = {
    {"ROUTER", "tree"},
    {"ROLE", "role"},
    {"SYSTEM", "system"},
    {"ID", "id"},
    {"ADDRESS", "address.name", Cell::kText, true},
    {"STATE", "state"},
    {"SINCE", "since_s", Cell::kDuration},
    {"RTT", "rtt_s", Cell::kDuration},
    {"CLOCK", "clock.offset_s", Cell::kDuration},
    {"VERSION", "version", Cell::kText, true},
    {"EPOCH", "epoch", Cell::kText, true},
};

constexpr Column kClocks[] = {
    {"ROUTER", "name"},
    {"OFFSET", "clock.offset_s", Cell::kDuration},
    {"WITHIN", "clock.uncertainty_s", Cell::kDuration},
    {"RTT", "rtt_s", Cell::kDuration},
    {"STATE", "state"},
};

// Orders the routers as a tree: each router is followed by its subordinate routers.
class Tree {
 public:
  explicit Tree(json::array& items) : items_(items) {}

  json::array run() {
    for (const std::string_view role : {"top", "system", "subsystem"}) {
      for (json::value& item : items_)
        if (item.is_object() && text_at(item.as_object(), "role") == role) place(item, 0);
    }
    for (json::value& item : items_) place(item, 0);  // routers with an unknown role
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
      const bool lower =
          (role == "top" && its_role == "system") ||
          (role == "system" && its_role == "subsystem" &&
           number_or_zero(below, "system") == system) ||
          (its_role.empty() && text_at(below, "parent") == name);  // a missing router has no role
      if (lower) place(other, depth + 1);
    }
  }

  json::array& items_;
  json::array out_;
};

json::object fleet(AdminClient& admin) {
  json::object answer = walk_fleet(admin);
  answer["items"] = Tree(item_array(answer)).run();
  return answer;
}

constexpr Column kClients[] = {
    {"CLIENT", "id"},
    {"NAME", "name"},
    {"PORT", "port"},
    {"PID", "pid"},
    {"UID", "uid", Cell::kText, true},
    {"PEER", "peer"},
    {"WHO", "subject", Cell::kText, true},
    {"JUDGED", "judged", Cell::kText, true},
    {"SINCE", "connected_s", Cell::kDuration},
    {"MAILBOXES", "mailboxes", Cell::kCount},
    {"IN", "in_messages", Cell::kCount},
    {"IN_BYTES", "in_bytes", Cell::kBytes},
    {"OUT", "out_messages", Cell::kCount},
    {"OUT_BYTES", "out_bytes", Cell::kBytes},
    {"DROPS", "drops", Cell::kCount, false, true},
    {"QUEUE", "queue_bytes", Cell::kBytes},
};

constexpr Column kLinks[] = {
    {"PEER", "via"},
    {"KIND", "kind"},
    {"STATE", "state"},
    {"SINCE", "since_s", Cell::kDuration},
    {"PATH", "path"},
    {"SECURE", "secure"},
    {"ADDRESS", "peer_address"},
    {"RTT", "rtt_s", Cell::kDuration},
    {"LOSS_IN", "loss_in", Cell::kPercent},
    {"LOSS_OUT", "loss_out", Cell::kPercent},
    {"MTU", "mtu_bytes"},
    {"MAILBOXES", "mailboxes", Cell::kCount},
    {"IN", "in_messages", Cell::kCount},
    {"OUT", "out_messages", Cell::kCount},
    {"DROPS", "drops", Cell::kCount, false, true},
    {"IN_BYTES", "wire_bytes_in", Cell::kBytes, true},
    {"OUT_BYTES", "wire_bytes_out", Cell::kBytes, true},
    {"IN_FLIGHT", "in_flight_bytes", Cell::kBytes, true},
    {"WINDOW", "window_bytes", Cell::kBytes, true},
    {"QUEUE_DELAY", "queue_delay_s", Cell::kDuration, true},
    {"QUEUES", "queue_bytes", Cell::kText, true},
    {"COMPRESSION", "compression.method", Cell::kText, true},
    {"RATIO", "compression.ratio", Cell::kText, true},
    {"CPU", "compression.cpu_s", Cell::kDuration, true},
    {"OFFSET", "clock.offset_s", Cell::kDuration, true},
    {"ACTIVE", "active", Cell::kText, true},
    {"HEARD", "heard_s", Cell::kDuration, true},
    {"REFUSED", "refusal", Cell::kText},
};

constexpr Column kPaths[] = {
    {"PEER", "via"},
    {"PATH", "path"},
    {"USED", "used"},
    {"STATE", "state"},
    {"SINCE", "since_s", Cell::kDuration},
    {"ADDRESS", "peer_address"},
    {"IN", "datagrams_in", Cell::kCount},
    {"OUT", "datagrams_out", Cell::kCount},
    {"IN_BYTES", "wire_bytes_in", Cell::kBytes, true},
    {"OUT_BYTES", "wire_bytes_out", Cell::kBytes, true},
    {"WHY", "why"},
};

// One item per path of a link with several paths. The path in use states why it was chosen.
void add_paths(const json::object& link, json::array& all) {
  const auto paths = items_of(link, "paths");
  if (paths.size() < 2) return;
  for (json::object path : objects(paths)) {
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
  if (!look.for_people()) return text;
  json::array paths;
  for (const json::object& link : objects(items_of(answer))) add_paths(link, paths);
  if (!paths.empty()) text += "\n" + render_items(paths, kPaths, look);
  for (const json::object& link : objects(items_of(answer)))
    if (const std::string faults = injected_faults(link); !faults.empty())
      text += fmt::format(
          "faults are injected into what is sent to {0}: {1}; `timsctl sim fault --link {0} heal` "
          "ends them\n",
          base::printable(text_at(link, "via")), faults);
  return text;
}

Exit act(Context& context, std::string_view what) {
  return command_router(
      context, {{"ask", "link"}, {"link", context.options.arguments.front()}, {"do", what}});
}

constexpr tims::Duration kServerEnds = std::chrono::seconds(5);  // after SIGINT

constexpr Column kDds[] = {
    {"Fleet", "fleet"},
    {"DDS", "dds.state"},
    {"Trouble", "dds.trouble"},
    {"DDS address", "dds.address"},
    {"Datagrams in", "dds.datagrams_in", Cell::kCount},
    {"Datagrams out", "dds.datagrams_out", Cell::kCount},
    {"Invalid", "dds.strange", Cell::kCount, false, true},
    {"Refused", "dds.refused", Cell::kCount, false, true},
    {"Unmatched", "dds.unmatched", Cell::kCount, false, true},
    {"Waiting", "dds.waiting_bytes", Cell::kBytes},
};

constexpr Column kRouters[] = {
    {"ROUTER", "name"},   {"ROLE", "role"},
    {"SYSTEM", "system"}, {"ID", "id"},
    {"LINKED", "linked"}, {"UDP", "udp"},
    {"DDS", "dds"},       {"EPOCH", "epoch", Cell::kText, true},
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

std::string draw_fleet(const json::object& answer, const Look& look) {
  std::string routers = render_items(with_texts(items_of(answer)), kRouters, look);
  if (!look.for_people()) return routers;
  if (text_at(answer, "fleet").empty())
    return "this router does not belong to a fleet: set name = \"...\" in [fleet] of its "
           "configuration\n";
  return render_page(answer, kDds, look) + "\n" + routers;
}

}  // namespace

Exit router_show(Context& context) {
  const auto ask = [](AdminClient& admin) { return admin.ask({{"ask", "status"}}); };
  return show(context, ask, page_of(kIdentity));
}

Exit router_list(Context& context) { return show(context, fleet, table_of(kFleet)); }

Exit clock(Context& context) { return show(context, fleet, table_of(kClocks)); }

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
  return show_items(context, {{"ask", "fleet"}}, kRouters, draw_fleet);
}

// Only SIGINT ends the server cleanly: after other signals it leaves shared memory files behind.
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

// --- timsctl mbx: mailboxes and their owners

namespace {

constexpr Column kMailboxes[] = {
    {"ADDRESS", "address.name"},
    {"RAW", "address.raw", Cell::kText, true},
    {"OWNER", "owner.name"},
    {"PID", "owner.pid"},
    {"VIA", "via"},
    {"PEER", "owner.peer", Cell::kText, true},
    {"SLOTS", "slots", Cell::kCount},
    {"MAX", "message_max_bytes", Cell::kBytes},
    {"WAITING", "waiting", Cell::kCount},
    {"RECEIVED", "received", Cell::kCount},
    {"REPLACED", "replaced", Cell::kCount, false, true},
    {"REFUSED", "refused", Cell::kCount, false, true},
    {"TOO_BIG", "too_big", Cell::kCount, false, true},
    {"RECLAIMED", "reclaimed", Cell::kCount, true, true},
    {"ASLEEP", "asleep", Cell::kText, true},
    {"AGE", "age_s", Cell::kDuration},
};

constexpr Column kMailbox[] = {
    {"Address", "address.name"},
    {"Raw address", "address.raw"},
    {"Owner", "owner.name"},
    {"Pid", "owner.pid"},
    {"Client", "owner.client"},
    {"Via", "via"},
    {"Peer", "owner.peer"},
    {"Registered for", "age_s", Cell::kDuration},
    {"Slots", "slots", Cell::kCount},
    {"Largest message", "message_max_bytes", Cell::kBytes},
    {"Waiting now", "waiting", Cell::kCount},
    {"Received", "received", Cell::kCount},
    {"Replaced by newer", "replaced", Cell::kCount, false, true},
    {"Refused, full", "refused", Cell::kCount, false, true},
    {"Refused, too big", "too_big", Cell::kCount, false, true},
    {"Incomplete", "reclaimed", Cell::kCount, false, true},
    {"Owner sleeps", "asleep"},
};

}  // namespace

Exit mbx_list(Context& context) {
  return show_items(context, with_match({{"ask", "mailboxes"}}, context.options), kMailboxes);
}

Exit mbx_show(Context& context) {
  const std::string& text = context.options.arguments.front();
  (void)need_address(text, kAnyWidths);
  const auto ask = [&](AdminClient& admin) {
    const tims::Address address = need_address(text, admin.widths());
    json::object answer = admin.ask({{"ask", "mailboxes"}, {"match", address.to_hex()}});
    if (items_of(answer).empty()) throw no_such_mailbox(address.to_string(admin.widths()));
    return answer;
  };
  const auto draw = [&](const json::object& answer, const Look& look) {
    return render_page(items_of(answer).front().as_object(), kMailbox, look);
  };
  return show(context, ask, draw);
}

// --- timsctl stats: outcomes of messages

namespace {

constexpr Column kCounts[] = {
    {"PORT", "port"},
    {"CLASS", "class"},
    {"OUTCOME", "outcome"},
    {"MESSAGES", "messages", Cell::kCount},
    {"BYTES", "bytes", Cell::kBytes},
    {"MEANING", "meaning"},
};
constexpr Column kByReason[] = {
    {"OUTCOME", "outcome"},
    {"MESSAGES", "messages", Cell::kCount},
    {"BYTES", "bytes", Cell::kBytes},
    {"MEANING", "meaning"},
};
constexpr Column kByPort[] = {
    {"PORT", "port"},
    {"MESSAGES", "messages", Cell::kCount},
    {"BYTES", "bytes", Cell::kBytes},
    {"DROPPED", "dropped_messages", Cell::kCount, false, true},
};
constexpr Column kByClass[] = {
    {"CLASS", "class"},
    {"PRIORITIES", "priorities"},
    {"MESSAGES", "messages", Cell::kCount},
    {"BYTES", "bytes", Cell::kBytes},
    {"DROPPED", "dropped_messages", Cell::kCount, false, true},
};

void add(json::object& item, std::string_view key, double more) {
  item[key] = static_cast<std::uint64_t>(number_or_zero(item, key) + more);
}

// "15-24"; "texts" for a class without priorities.
std::string priorities_of(const json::value& message_class, const json::array& classes) {
  if (classes.empty()) return {};  // an older router does not report classes
  const auto number = message_class.to_number<std::size_t>();
  const auto first_of = [&](std::size_t i) {
    if (i == 0) return 0;
    return i <= classes.size() ? classes[i - 1].to_number<int>() : 256;
  };
  const int first = first_of(number);
  const int last = first_of(number + 1) - 1;
  if (last < first) return "texts";
  return first == last ? std::to_string(first) : fmt::format("{}-{}", first, last);
}

// One item for each value of `key`, the numbers added up.
json::array grouped(std::span<const json::value> items, std::string_view key,
                    const json::array& classes) {
  json::array groups;
  for (const json::object& item : objects(items)) {
    auto group = std::ranges::find_if(groups, [&](const json::value& g) {
      return text_at(g.as_object(), key) == text_at(item, key);
    });
    if (group == groups.end()) {
      json::object fresh{{key, item.at(key)}};
      if (key == "outcome") fresh["meaning"] = item.at("meaning");
      if (key == "class") fresh["priorities"] = priorities_of(item.at("class"), classes);
      groups.push_back(std::move(fresh));
      group = groups.end() - 1;
    }
    const bool dropped = text_at(item, "dropped") == "true";
    json::object& sum = group->as_object();
    add(sum, "messages", number_or_zero(item, "messages"));
    add(sum, "bytes", number_or_zero(item, "bytes"));
    add(sum, "dropped_messages", dropped ? number_or_zero(item, "messages") : 0);
  }
  return groups;
}

// Messages between programs of the same host bypass the router; only mailboxes count them.
std::string mailboxes_line(const json::object& answer) {
  const auto count = [&](std::string_view name) {
    return base::human_count(number_or_zero(answer, fmt::format("mailboxes.{}", name)));
  };
  return fmt::format(
      "\nMailboxes of this host: {} received, {} replaced, {} refused, {} too big, "
      "{} incomplete\n",
      count("received"), count("replaced"), count("refused"), count("too_big"), count("reclaimed"));
}

}  // namespace

Exit stats(Context& context) {
  const std::string& by = context.options.by;
  std::span<const Column> columns = kCounts;
  if (by == "reason") columns = kByReason;
  if (by == "port") columns = kByPort;
  if (by == "class") columns = kByClass;
  const auto ask = [&](AdminClient& admin) {
    json::object answer = admin.ask({{"ask", "stats"}});
    if (!by.empty())
      answer["items"] =
          grouped(items_of(answer), by == "reason" ? "outcome" : by,
                  answer.contains("classes") ? answer.at("classes").as_array() : json::array());
    if (!context.options.sort.empty())
      sort_items(item_array(answer), columns, context.options.sort);
    return answer;
  };
  const auto draw = [&](const json::object& answer, const Look& look) {
    const std::string table = render_items(items_of(answer), columns, look);
    return look.for_people() ? table + mailboxes_line(answer) : table;
  };
  return show(context, ask, draw);
}

// --- timsctl config show: the configuration of the router

namespace {

constexpr Column kWithOrigin[] = {{"KEY", "key"},
                                  {"VALUE", "value"},
                                  {"ORIGIN", "origin"},
                                  {"RELOADABLE", "reloadable", Cell::kText, true}};
constexpr Column kWithout[] = {{"KEY", "key"},
                               {"VALUE", "value"},
                               {"ORIGIN", "origin", Cell::kText, true},
                               {"RELOADABLE", "reloadable", Cell::kText, true}};

}  // namespace

Exit config_show(Context& context) {
  return show_items(context, {{"ask", "config"}},
                    context.options.origin ? std::span<const Column>(kWithOrigin) : kWithout);
}

}  // namespace timsctl
