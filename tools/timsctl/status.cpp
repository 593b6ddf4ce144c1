// timsctl status: the one screen to look at first.
#include <algorithm>
#include <iterator>
#include <set>

#include <fmt/format.h>

#include "base/measure.h"
#include "base/text.h"
#include "base/wall_time.h"
#include "tools/cli/context.h"
#include "tools/timsctl/findings.h"
#include "tools/timsctl/verbs.h"

namespace timsctl {

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

std::string event_lines(const json::object& status, const Look& look) {
  std::string text;
  const json::value* events = at_path(status, "events");
  if (events == nullptr || !events->is_array()) return text;
  for (const json::value& event : events->get_array()) {
    const std::string time = text_at(event.as_object(), "time");
    text += fmt::format("  {}  {}\n", paint(local_time(time, look.utc), Tone::kDim, look.colour),
                        base::printable(text_at(event.as_object(), "text")));
  }
  return text;
}

std::string draw(const json::object& status, const Look& look) {
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
               fmt::format("{} messages, {}; local ones go past the router", count("messages"),
                           base::human_bytes(number_or_zero(status, "bytes"))));
  text += line("Dropped", drops_line(status, look));
  text +=
      line("Memory", fmt::format("{}, longest turn {}",
                                 base::human_bytes(number_or_zero(status, "rss_bytes")),
                                 base::human_duration(number_or_zero(status, "longest_turn_s"))));
  const std::string events = event_lines(status, look);
  return events.empty() ? text : text + "\n" + events;
}

constexpr double kEventsAsked = 200;
constexpr std::ptrdiff_t kEventsShown = 5;

// Clients that are command-line tools, among those the events tell of.
std::set<std::string> tools_in(const json::array& events, const tims::AddressWidths& widths) {
  std::set<std::string> tools;
  for (const json::value& value : events) {
    const json::object& event = value.as_object();
    const auto address = tims::Address::parse(text_at(event, "address.raw"));
    if (address && address->fields(widths).class_id == tims::class_id::kTool)
      tools.insert(text_at(event, "client.client"));
  }
  return tools;
}

// The last events without those that tools make by asking.
json::array foreign_events(AdminClient& admin, double last) {
  const auto since = static_cast<std::int64_t>(std::max(0.0, last - kEventsAsked));
  json::object answer = admin.ask({{"ask", "events"}, {"since", since}});
  json::array& events = items_of(answer);
  const auto tools = tools_in(events, admin.widths());
  json::array out;
  for (json::value& event : events)
    if (!tools.contains(text_at(event.as_object(), "client.client")))
      out.push_back(std::move(event));
  if (std::ssize(out) > kEventsShown) out.erase(out.begin(), out.end() - kEventsShown);
  return out;
}

json::object ask_status(AdminClient& admin) {
  json::object status = admin.ask({{"ask", "status"}});
  status["events"] = foreign_events(admin, number_or_zero(status, "last_event"));
  if (number_or_zero(status, "drops") > 0) {
    const json::object clients = admin.ask({{"ask", "clients"}});
    if (std::string to = lost_to(items_of(clients), {}); !to.empty())
      status["dropped_to"] = std::move(to);
  }
  return status;
}

constexpr Column kColumns[] = {
    {"ROUTER", "name"},
    {"ADDRESS", "address.name"},
    {"VERSION", "version"},
    {"PID", "pid"},
    {"UP", "uptime_s", As::kDuration},
    {"CLIENTS", "clients", As::kCount},
    {"MAILBOXES", "mailboxes", As::kCount},
    {"MESSAGES", "messages", As::kCount},
    {"BYTES", "bytes", As::kBytes},
    {"DROPS", "drops", As::kCount, false, true},
    {"DROPS/MIN", "drops_last_minute", As::kCount, false, true},
};

}  // namespace

Exit status(Context& context) {
  return show(context, ask_status, [](const json::object& answer, const Look& look) {
    if (look.format == Format::kTable || look.format == Format::kWide) return draw(answer, look);
    const json::value item(answer);
    return render_items({&item, 1}, kColumns, look);
  });
}

}  // namespace timsctl
