// timsctl mbx: mailboxes and their owners.
#include <fmt/format.h>

#include "tools/cli/arguments.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/timsctl/verbs.h"

namespace timsctl {

namespace {

constexpr Column kList[] = {
    {"ADDRESS", "address.name"},
    {"RAW", "address.raw", As::kText, true},
    {"OWNER", "owner.name"},
    {"PID", "owner.pid"},
    {"VIA", "via"},
    {"PEER", "owner.peer", As::kText, true},
    {"SLOTS", "slots", As::kCount},
    {"MAX", "message_max_bytes", As::kBytes},
    {"WAITING", "waiting", As::kCount},
    {"RECEIVED", "received", As::kCount},
    {"REPLACED", "replaced", As::kCount, false, true},
    {"REFUSED", "refused", As::kCount, false, true},
    {"TOO_BIG", "too_big", As::kCount, false, true},
    {"RECLAIMED", "reclaimed", As::kCount, true, true},
    {"ASLEEP", "asleep", As::kText, true},
    {"AGE", "age_s", As::kDuration},
};

constexpr Column kPage[] = {
    {"Address", "address.name"},
    {"Raw address", "address.raw"},
    {"Owner", "owner.name"},
    {"Pid", "owner.pid"},
    {"Client", "owner.client"},
    {"Via", "via"},
    {"Peer", "owner.peer"},
    {"Registered for", "age_s", As::kDuration},
    {"Slots", "slots", As::kCount},
    {"Largest message", "message_max_bytes", As::kBytes},
    {"Waiting now", "waiting", As::kCount},
    {"Received", "received", As::kCount},
    {"Replaced by newer", "replaced", As::kCount, false, true},
    {"Refused, full", "refused", As::kCount, false, true},
    {"Refused, too big", "too_big", As::kCount, false, true},
    {"Left half-written", "reclaimed", As::kCount, false, true},
    {"Owner sleeps", "asleep"},
};

}  // namespace

Exit mbx_list(Context& context) {
  return show_items(context, with_match({{"ask", "mailboxes"}}, context.options), kList);
}

Exit mbx_show(Context& context) {
  const std::string& text = context.options.arguments.front();
  (void)need_address(text, kAnyWidths);
  const auto ask = [&](AdminClient& admin) {
    const tims::Address address = need_address(text, admin.widths());
    json::object answer = admin.ask({{"ask", "mailboxes"}, {"match", address.to_hex()}});
    if (items_of(std::as_const(answer)).empty())
      throw Failure(
          Exit::kNoSuch, "no_such_mailbox",
          fmt::format("{}: nobody has registered this address", address.to_string(admin.widths())),
          "`timsctl mbx list` shows all");
    return answer;
  };
  const auto draw = [&](const json::object& answer, const Look& look) {
    return render_page(items_of(answer).front().as_object(), kPage, look);
  };
  return show(context, ask, draw);
}

}  // namespace timsctl
