// timsctl trace: a message that every router on its way tells about.
#include <algorithm>

#include <fmt/format.h>

#include "os/clock.h"
#include "tools/timsctl/commands.h"
#include "tools/timsctl/context.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/humanize.h"
#include "tools/timsctl/values.h"

namespace timsctl {

namespace {

constexpr Column kHops[] = {
    {"HOP", "hop"},
    {"ROUTER", "router"},
    {"FROM", "from.name"},
    {"TO", "to.name"},
    {"WAITED", "waited_s", As::kDuration},
    {"TIME", "time"},
};

// A record, if the message is one.
std::optional<json::object> record_of(const Message& message) {
  if (message.header.type != tims::type::kHopRecord) return std::nullopt;
  return json_of(message);
}

}  // namespace

Exit trace(Context& context) {
  if (std::holds_alternative<TcpHost>(context.host))
    throw usage_error("a message that comes over TCP is not traced", "-H unix:PATH on that host");
  (void)need_address(context.options.arguments.front(), kAnyWidths);
  const auto connection = context.connect();
  const tims::AddressWidths widths = connection->widths();
  const tims::Address target = need_address(context.options.arguments.front(), widths);
  const std::int8_t type = context.options.type.empty()
                               ? tims::type::kGetStatus
                               : need_type(context.options.type, target.fields(widths).class_id);
  const std::string name = target.to_string(connection->widths());
  const tims::Time sent = tims::os::now();
  auto result = connection->send({.dest = target,
                                  .type = type,
                                  .priority = context.options.priority,
                                  .seq_nr = connection->next_seq_nr(),
                                  .trace = true},
                                 {});
  if (!result) throw failure_of(result.error(), name);
  json::array hops;
  std::optional<Message> answer;
  std::optional<double> seconds;
  // Records come as fast as the answer, not necessarily before it.
  tims::Time deadline = tims::os::deadline_after(context.options.timeout);
  while (auto message = receive(*connection, context.signals, deadline)) {
    if (auto record = record_of(*message)) {
      hops.push_back(std::move(*record));
    } else if (message->header.src == target) {
      seconds = std::chrono::duration<double>(tims::os::now() - sent).count();
      answer = std::move(*message);
      deadline = std::min(deadline, tims::os::deadline_after(std::chrono::milliseconds(100)));
    }
  }
  std::ranges::sort(hops, {},
                    [](const json::value& hop) { return number_or_zero(hop.as_object(), "hop"); });
  const bool reached = answer && answer->header.type != tims::type::kNotAvailable;
  if (context.out.json()) {
    context.out.write(json::object{{"schema", "tims/trace/1"},
                                   {"target", name},
                                   {"reached", reached},
                                   {"rtt_s", seconds ? json::value(*seconds) : json::value()},
                                   {"items", std::move(hops)}});
  } else {
    if (hops.empty()) context.out.note("no router was on its way: it is on this host");
    context.out.write(render_items(hops, kHops, context.out.look()));
    const std::string end =
        !answer ? "no answer"
                : fmt::format("{} after {}",
                              reached ? type_name(answer->header.type) : "no such mailbox",
                              human_duration(*seconds));
    context.out.write(fmt::format("{}: {}\n", name, end));
  }
  if (!answer) return Exit::kTimeout;
  return reached ? Exit::kDone : Exit::kNoSuch;
}

}  // namespace timsctl
