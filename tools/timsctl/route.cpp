// timsctl route: where messages go.
#include <fmt/format.h>

#include "base/measure.h"
#include "base/text.h"
#include "os/clock.h"
#include "tools/cli/admin_client.h"
#include "tools/cli/arguments.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/message.h"

namespace timsctl {
namespace {

constexpr Column kRoutes[] = {
    {"ADDRESS", "address.name"},
    {"RAW", "address.raw"},
    {"VIA", "via"},
    {"OWNER", "owner.name"},
    {"PID", "owner.pid"},
    {"PEER", "owner.peer"},
    {"ROUTER", "router.name"},
    {"HOPS", "hops", Cell::kText, true},
    {"CLIENT", "owner.client", Cell::kText, true},
    {"AGE", "age_s", Cell::kDuration},
};

constexpr Column kRoutesEverywhere[] = {
    {"AT", "at"},
    {"ADDRESS", "address.name"},
    {"RAW", "address.raw"},
    {"VIA", "via"},
    {"OWNER", "owner.name"},
    {"HOPS", "hops"},
    {"AGE", "age_s", Cell::kDuration},
};

std::string draw_verdict(const json::object& route, const Look& look) {
  const std::string verdict = text_at(route, "verdict");
  const bool delivered = verdict != "no_route" && verdict != "denied";
  std::string text = fmt::format("{}: {}, {}\n", text_at(route, "address.name"),
                                 paint(verdict, delivered ? Tone::kGood : Tone::kBad, look.colour),
                                 base::printable(text_at(route, "reason")));
  const std::string via = text_at(route, "via");
  if (!via.empty())
    text += fmt::format("  via {}, registered for {}\n", via,
                        base::human_duration(number_or_zero(route, "age_s")));
  if (!delivered)
    text += text_at(route, "not_available") == "true"
                ? "  the sender receives NOT_AVAILABLE\n"
                : "  the message is dropped: only a command (type > 0) is answered\n";
  if (text_at(route, "from_registered") == "false")
    text += "  --from is not registered: local senders may only send from their own mailboxes\n";
  return text;
}

Exit change_route(Context& context, std::string_view ask) {
  const std::vector<std::string>& arguments = context.options.arguments;
  json::object question = with_match({{"ask", ask}}, context.options);
  if (arguments.size() > 1) question["via"] = arguments[1];
  return command_router(context, question);
}

}  // namespace

Exit route_add(Context& context) { return change_route(context, "route_add"); }
Exit route_del(Context& context) { return change_route(context, "route_del"); }

Exit route_show(Context& context) {
  if (context.options.all_routers) {
    const json::object question = with_match({{"ask", "routes"}}, context.options);
    return show(
        context, [&](AdminClient& admin) { return ask_everywhere(admin, question); },
        table_of(kRoutesEverywhere));
  }
  return show_items(context, with_match({{"ask", "routes"}}, context.options), kRoutes);
}

Exit route_get(Context& context) {
  const Options& options = context.options;
  (void)need_address(options.arguments.front(), kAnyWidths);
  const auto connection = context.connect();
  AdminClient admin = context.admin(*connection);
  const tims::Address to = need_address(options.arguments.front(), admin.widths());
  json::object question{{"ask", "route"}, {"to", to.to_hex()}};
  if (!options.from.empty()) question["from"] = need_address(options.from, admin.widths()).to_hex();
  question["type"] = type_to_assume(options, to, admin.widths());
  const json::object answer = admin.ask(question);
  const std::string verdict = text_at(answer, "verdict");
  context.out.write(answer, [&] {
    const Look& look = context.out.look();
    return look.for_people() ? draw_verdict(answer, look) : verdict + "\n";
  });
  return verdict == "no_route" || verdict == "denied" ? Exit::kNo : Exit::kDone;
}

// --- route watch: registrations and withdrawals. The router answers the request when there is a
// new event (long polling).

namespace {

using namespace std::chrono_literals;

class RouteWatch {
 public:
  explicit RouteWatch(Context& context)
      : context_(context),
        left_(context.options.count.value_or(UINT64_MAX)),
        end_(context.run_end()) {
    if (!context.options.arguments.empty())
      (void)need_pattern(context.options.arguments.front(), kAnyWidths);
  }

  Exit run() {
    open();
    context_.out.note(fmt::format("watching {}; stop with Ctrl-C", connection_->where()));
    while (left_ > 0 && tims::os::now() < end_) {
      try {
        step();
      } catch (const Failure& failure) {
        if (failure.exit != Exit::kNoRouter && failure.exit != Exit::kTimeout) throw;
        reopen(failure);
      }
    }
    return Exit::kDone;
  }

 private:
  void open() {
    connection_ = context_.connect();
    if (since_) return;
    AdminClient admin = context_.admin(*connection_);
    if (!context_.options.arguments.empty())
      pattern_ = need_pattern(context_.options.arguments.front(), admin.widths());
    const json::object answer = admin.ask({{"ask", "events"}});
    remember(answer);
  }

  void remember(const json::object& answer) {
    since_ = static_cast<std::int64_t>(number_or_zero(answer, "last"));
    epoch_ = text_at(answer, "epoch");
  }

  void reopen(const Failure& failure) {
    context_.out.note(failure.message + "; retrying");
    connection_.reset();
    while (!connection_ && tims::os::now() < end_) {
      context_.signals.sleep_until(std::min(tims::os::deadline_after(500ms), end_));
      try {
        open();
      } catch (const Failure& again) {
        if (again.exit != Exit::kNoRouter && again.exit != Exit::kTimeout) throw;
        connection_.reset();
      }
    }
  }

  void step() {
    const auto wait = std::min<tims::Duration>(10s, end_ - tims::os::now());
    const auto wait_ms = std::max<std::int64_t>(
        0, std::chrono::duration_cast<std::chrono::milliseconds>(wait).count());
    AdminClient admin = context_.admin(*connection_);
    const json::object answer = admin.ask(
        {{"ask", "events"}, {"since", *since_}, {"epoch", epoch_}, {"wait_ms", wait_ms}}, wait);
    if (text_at(answer, "epoch") != epoch_) context_.out.note("the router has restarted");
    if (const double lost = number_or_zero(answer, "lost"); lost > 0)
      context_.out.note(fmt::format(
          "{:.0f} events were lost: they occurred faster than they could be read", lost));
    for (const json::object& item : objects(items_of(answer))) print(item, answer);
    remember(answer);
  }

  [[nodiscard]] bool wanted(const json::object& event) const {
    const std::string kind = text_at(event, "kind");
    if (kind != "registered" && kind != "withdrawn" && kind != "address_refused" &&
        kind != "delete_refused")
      return false;
    const auto address = parse_address(text_at(event, "address.raw"));
    return pattern_.matches(address.value_or(tims::Address()));
  }

  void print(const json::object& event, const json::object& answer) {
    if (left_ == 0 || !wanted(event)) return;
    --left_;
    const Look& look = context_.out.look();
    if (look.format == Format::kJson) {
      json::object line{{"schema", "tims/event/1"}, {"router", text_at(answer, "router")}};
      for (const auto& [key, value] : event) line[key] = value;
      return context_.out.write(line);
    }
    const std::string kind = text_at(event, "kind");
    const Tone tone = kind == "registered"  ? Tone::kGood
                      : kind == "withdrawn" ? Tone::kWarning
                                            : Tone::kBad;
    context_.out.write(fmt::format("{}  {}  {}\n", local_time(text_at(event, "time"), look.utc),
                                   paint(fmt::format("{:<15}", kind), tone, look.colour),
                                   base::printable(text_at(event, "text"))));
  }

  Context& context_;
  std::uint64_t left_;
  tims::Time end_;
  tims::AddressPattern pattern_;
  std::unique_ptr<Connection> connection_;
  std::optional<std::int64_t> since_;
  std::string epoch_;  // epoch of the router to which since_ refers
};

}  // namespace

Exit route_watch(Context& context) { return RouteWatch(context).run(); }

}  // namespace timsctl
