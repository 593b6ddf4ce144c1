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
    {"PATH", "path", As::kText, true},
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
  return show_items(context, question, kLinks);
}

Exit link_up(Context& context) { return act(context, "up"); }
Exit link_down(Context& context) { return act(context, "down"); }
Exit link_reset(Context& context) { return act(context, "reset"); }

}  // namespace timsctl
