// timsctl router: who the router is, and who is attached to it.
#include "tools/timsctl/commands.h"
#include "tools/timsctl/show.h"

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
    {"Memory", "rss_bytes", As::kBytes},
    {"Of it, table", "table_bytes", As::kBytes},
    {"Longest turn", "longest_turn_s", As::kDuration},
};

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

Exit router_clients(Context& context) {
  return show_items(context, {{"ask", "clients"}}, kClients);
}

}  // namespace timsctl
