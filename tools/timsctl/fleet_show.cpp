// timsctl fleet: routers that find each other by the name of their fleet.
#include <csignal>

#include <fmt/format.h>

#include "router/config/config.h"
#include "tools/timsctl/commands.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/process.h"
#include "tools/timsctl/show.h"

namespace timsctl {

namespace {

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
  const Child server =
      Child::start({.command = {"fast-discovery-server", "-i", "0", "-l", endpoint->host, "-p",
                                std::to_string(endpoint->port)}});
  try {
    (void)context.signals.wait(server.descriptor(), tims::kNever);
  } catch (const Interrupted&) {
    server.signal(SIGINT);
    if (!server.has_ended(kServerEnds)) server.signal(SIGKILL);
  }
  return server.reap() == 0 ? Exit::kDone : Exit::kNo;
}

}  // namespace timsctl
