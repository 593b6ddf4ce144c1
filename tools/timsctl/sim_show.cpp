// timsctl sim show and what else only looks at a fleet's state.
#include <fmt/format.h>

#include "tools/timsctl/commands.h"
#include "tools/timsctl/context.h"
#include "tools/timsctl/process.h"
#include "tools/timsctl/sim/plan.h"
#include "tools/timsctl/sim/quality.h"
#include "tools/timsctl/sim/state.h"

namespace timsctl {

namespace {

constexpr Column kHosts[] = {{"HOST", "name"},
                             {"ROLE", "role"},
                             {"SYSTEM", "system", As::kText},
                             {"STATE", "state"},
                             {"ADDRESSES", "address_list"},
                             {"ROUTER", "router"},
                             {"NAMESPACE", "network", As::kText, true}};
constexpr Column kPrograms[] = {{"HOST", "host"},   {"PROGRAM", "name"},
                                {"STATE", "state"}, {"PID", "pid"},
                                {"END", "end"},     {"LOG", "log", As::kText, true}};
constexpr Column kLines[] = {
    {"LINE", "name"}, {"UPPER", "upper"}, {"LOWER", "lower"}, {"STATE", "state"}};

// What tables show of a host beside what is written: one word for its programs, one cell of
// addresses.
json::array hosts_of(const json::object& fleet) {
  json::array hosts;
  const json::value* list = at_path(fleet, "hosts");
  if (list == nullptr || !list->is_array()) return hosts;
  for (const json::value& value : list->get_array()) {
    json::object host = value.as_object();
    std::size_t ended = 0;
    const json::array& programs = host.at("programs").as_array();
    for (const json::value& program : programs)
      ended += text_at(program.as_object(), "state") == "running" ? 0U : 1U;
    host["state"] = ended == 0                 ? "running"
                    : ended == programs.size() ? "ended"
                                               : fmt::format("{} ended", ended);
    std::string addresses;
    for (const json::value& address : host.at("addresses").as_array())
      addresses.append(addresses.empty() ? "" : " ").append(address.as_string());
    host["address_list"] = addresses;
    hosts.push_back(std::move(host));
  }
  return hosts;
}

json::array programs_of(const json::array& hosts) {
  json::array programs;
  for (const json::value& host : hosts)
    for (const json::value& value : host.as_object().at("programs").as_array()) {
      json::object program = value.as_object();
      program["host"] = text_at(host.as_object(), "name");
      programs.push_back(std::move(program));
    }
  return programs;
}

std::string draw_fleet(const json::object& fleet, const Look& look) {
  std::string text = fmt::format("fleet {}: {}", text_at(fleet, "name"), text_at(fleet, "state"));
  if (text_at(fleet, "state") == "crashed")
    return text + fmt::format(" (`timsctl sim down {}` cleans up)\n", text_at(fleet, "name"));
  const json::array hosts = hosts_of(fleet);
  text += fmt::format(", pid {}, {}\n\n", text_at(fleet, "pid"), text_at(fleet, "folder"));
  text += render_items({hosts.data(), hosts.size()}, kHosts, look) + "\n";
  if (const json::value* lines = at_path(fleet, "lines"); lines != nullptr && lines->is_array())
    text += render_items({lines->get_array().data(), lines->get_array().size()}, kLines, look);
  const json::array programs = programs_of(hosts);
  return text + "\n" + render_items({programs.data(), programs.size()}, kPrograms, look);
}

json::object fleet_state(const std::string& name) {
  json::object fleet = sim::read_state(name);
  fleet["name"] = name;
  fleet["state"] = sim::is_running(name) ? "running" : "crashed";
  return fleet;
}

std::vector<std::string> names_in(const json::object& fleet, std::string_view list) {
  std::vector<std::string> names;
  const json::value* items = at_path(fleet, list);
  if (items == nullptr || !items->is_array()) return names;
  for (const json::value& item : items->get_array())
    names.push_back(text_at(item.as_object(), "name"));
  return names;
}

std::vector<std::string> words_for_lines() {
  std::vector<std::string> words = {"cut", "heal", "direction=up", "direction=down"};
  for (const auto& [name, quality] : sim::built_in_profiles()) words.push_back(name);
  for (const std::string_view key : sim::quality_keys()) words.push_back(std::string(key) + "=");
  return words;
}

}  // namespace

Exit sim_show(Context& context) {
  json::array items;
  for (const std::string& name : sim::fleets())
    if (context.options.arguments.empty() || context.options.arguments.front() == name)
      items.push_back(fleet_state(name));
  if (items.empty() && !context.options.arguments.empty())
    throw Failure(Exit::kNoSuch, "no_such_fleet",
                  fmt::format("no fleet {}", context.options.arguments.front()),
                  "`timsctl sim show`");
  if (context.out.json()) {
    context.out.write(json::object{{"schema", "tims/sim_show/1"}, {"items", std::move(items)}});
    return Exit::kDone;
  }
  if (items.empty()) context.out.note("no fleet runs on this host");
  for (const json::value& item : items)
    context.out.write(draw_fleet(item.as_object(), context.out.look()));
  return Exit::kDone;
}

Exit sim_exec(Context& context) {
  sim::need_root();
  const json::object fleet = sim::read_state(sim::chosen_fleet(context.options.fleet));
  const auto& arguments = context.options.arguments;
  std::vector<std::string> names;
  for (const json::value& value : hosts_of(fleet)) {
    const json::object& host = value.as_object();
    names.push_back(text_at(host, "name"));
    if (names.back() != arguments.front()) continue;
    become({.command = {arguments.begin() + 1, arguments.end()},
            .network = text_at(host, "network"),
            .environment = sim::environment_at(text_at(host, "router"))});
  }
  throw sim::no_such("host", arguments.front(),
                     std::vector<std::string_view>(names.begin(), names.end()));
}

std::vector<std::string> sim_candidates(std::string_view verb, std::size_t argument) {
  if (verb == "show" || verb == "down") return sim::fleets();
  if (verb == "fault" && argument > 0) return words_for_lines();
  if (verb == "kill" && argument > 0) return {"router"};
  if (verb == "up" || argument > 0) return {};
  try {
    const json::object fleet = sim::read_state(sim::chosen_fleet(""));
    return names_in(fleet, verb == "fault" ? "lines" : "hosts");
  } catch (const Failure&) {
    return {};  // no fleet, no names
  }
}

}  // namespace timsctl
