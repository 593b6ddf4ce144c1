// timsctl route: where messages go.
#include <fmt/format.h>

#include "tools/timsctl/commands.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/fleet.h"
#include "tools/timsctl/humanize.h"
#include "tools/timsctl/show.h"
#include "tools/timsctl/values.h"

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
    {"HOPS", "hops", As::kText, true},
    {"CLIENT", "owner.client", As::kText, true},
    {"AGE", "age_s", As::kDuration},
};

constexpr Column kRoutesEverywhere[] = {
    {"AT", "at"},
    {"ADDRESS", "address.name"},
    {"RAW", "address.raw"},
    {"VIA", "via"},
    {"OWNER", "owner.name"},
    {"HOPS", "hops"},
    {"AGE", "age_s", As::kDuration},
};

std::string draw_verdict(const json::object& route, const Look& look) {
  const std::string verdict = text_at(route, "verdict");
  const bool delivered = verdict != "no_route";
  std::string text = fmt::format("{}: {}, {}\n", text_at(route, "address.name"),
                                 paint(verdict, delivered ? Tone::kGood : Tone::kBad, look.colour),
                                 printable(text_at(route, "reason")));
  const std::string via = text_at(route, "via");
  if (!via.empty())
    text += fmt::format("  via {}, registered for {}\n", via,
                        human_duration(number_or_zero(route, "age_s")));
  if (!delivered)
    text += text_at(route, "not_available") == "true"
                ? "  the sender gets NOT_AVAILABLE\n"
                : "  the message is dropped: only a command (type > 0) is answered\n";
  if (text_at(route, "from_registered") == "false")
    text += "  --from is not registered: local senders may only send from their own mailboxes\n";
  return text;
}

Exit change_route(Context& context, std::string_view ask) {
  const std::vector<std::string>& arguments = context.options.arguments;
  (void)need_pattern(arguments[0], kAnyWidths);
  json::object question{{"ask", ask}, {"match", pattern_text(arguments[0])}};
  if (arguments.size() > 1) question["via"] = arguments[1];
  const auto connection = context.connect();
  AdminClient admin = context.admin(*connection);
  const json::object answer = admin.ask(question);
  if (context.out.json()) context.out.write(answer);
  return Exit::kDone;
}

}  // namespace

Exit route_add(Context& context) { return change_route(context, "route_add"); }
Exit route_del(Context& context) { return change_route(context, "route_del"); }

Exit route_show(Context& context) {
  if (context.options.all_routers) {
    const json::object question = with_match({{"ask", "routes"}}, context.options);
    return show(
        context, [&](AdminClient& admin) { return ask_everywhere(admin, question); },
        [](const json::object& answer, const Look& look) {
          return render_items(items_of(answer), kRoutesEverywhere, look);
        });
  }
  return show_items(context, with_match({{"ask", "routes"}}, context.options), kRoutes);
}

Exit route_get(Context& context) {
  const Options& options = context.options;
  (void)need_address(options.arguments.front(), kAnyWidths);
  const auto connection = context.connect();
  AdminClient admin = context.admin(*connection);
  const auto hex = [&](std::string_view text) {
    return need_address(text, admin.widths()).to_hex();
  };
  const tims::Address to = need_address(options.arguments.front(), admin.widths());
  json::object question{{"ask", "route"}, {"to", to.to_hex()}};
  if (!options.from.empty()) question["from"] = hex(options.from);
  question["type"] = options.type.empty()
                         ? tims::type::kGetStatus
                         : need_type(options.type, to.fields(admin.widths()).class_id);
  const json::object answer = admin.ask(question);
  const Look& look = context.out.look();
  if (look.format == Format::kJson)
    context.out.write(answer);
  else if (look.format == Format::kTable || look.format == Format::kWide)
    context.out.write(draw_verdict(answer, look));
  else
    context.out.write(text_at(answer, "verdict") + "\n");
  return text_at(answer, "verdict") == "no_route" ? Exit::kNo : Exit::kDone;
}

}  // namespace timsctl
