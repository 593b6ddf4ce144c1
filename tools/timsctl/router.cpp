// timsctl router: who the router is, and who is attached to it.
#include "tools/timsctl/commands.h"
#include "tools/timsctl/fleet.h"
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

}  // namespace timsctl
