// timsctl sim: a fleet of robots on this machine, in network namespaces.
#include <filesystem>

#include <fmt/format.h>

#include "os/file.h"
#include "tools/cli/context.h"
#include "tools/cli/program.h"
#include "tools/cli/service.h"
#include "tools/sim/plan.h"
#include "tools/sim/quality.h"
#include "tools/sim/supervisor.h"

namespace timsctl {
namespace {

sim::Fleet read_fleet_file(Context& context) {
  const std::string& path = context.options.arguments.front();
  auto text = tims::os::read_file(path);
  if (!text)
    throw Failure(Exit::kNoSuch, "no_such_file", fmt::format("cannot read {}", path),
                  "see deploy/fleets/demo.toml for an example");
  sim::FleetFile read = sim::read_fleet({path, std::move(*text)});
  fail_if_any(read.problems, "bad_fleet", "deploy/fleets/README.md");
  if (!context.options.fleet.empty()) {
    if (!sim::is_fleet_name(context.options.fleet))
      throw usage_error(
          fmt::format("--fleet: \"{}\" is not a name: at most {} small letters and "
                      "digits",
                      context.options.fleet, sim::kFleetNameMax));
    read.fleet.name = context.options.fleet;
  }
  return std::move(read.fleet);
}

// Starts the fleet, calls `ready`, and runs until the end.
Exit run_fleet(Context& context, const sim::Plan& plan, const std::function<void()>& ready) {
  sim::Supervisor fleet(context, plan);
  fleet.bring_up();
  ready();
  fleet.serve(context.run_end());
  return fleet.failures() == 0 ? Exit::kDone : Exit::kNo;
}

Exit ask(Context& context, const json::object& question) {
  sim::need_root();
  const std::string fleet = sim::chosen_fleet(context.options.fleet);
  const auto timeout = std::max(context.options.timeout, kServiceAnswers);
  const json::object answer = sim::running_fleets().ask(fleet, question, context.signals, timeout);
  if (context.out.json())
    context.out.write(answer);
  else if (at_path(answer, "line") != nullptr)
    context.out.note(fmt::format("{}: {}", text_at(answer, "line"), text_at(answer, "state")));
  return Exit::kDone;
}

constexpr Column kHosts[] = {{"HOST", "name"},
                             {"ROLE", "role"},
                             {"SYSTEM", "system", Cell::kText},
                             {"STATE", "state"},
                             {"ADDRESSES", "address_list"},
                             {"ROUTER", "router"},
                             {"NAMESPACE", "network", Cell::kText, true}};
constexpr Column kPrograms[] = {{"HOST", "host"},   {"PROGRAM", "name"},
                                {"STATE", "state"}, {"PID", "pid"},
                                {"END", "end"},     {"LOG", "log", Cell::kText, true}};
constexpr Column kLines[] = {
    {"LINE", "name"}, {"UPPER", "upper"}, {"LOWER", "lower"}, {"STATE", "state"}};

// Adds derived cells of a host for tables: the state of its programs, and all addresses.
json::array hosts_of(const json::object& fleet) {
  json::array hosts;
  for (json::object host : objects(items_of(fleet, "hosts"))) {
    std::size_t ended = 0;
    const auto programs = items_of(host, "programs");
    for (const json::object& program : objects(programs))
      ended += text_at(program, "state") == "running" ? 0U : 1U;
    host["state"] = ended == 0                 ? "running"
                    : ended == programs.size() ? "ended"
                                               : fmt::format("{} ended", ended);
    std::string addresses;
    for (const json::value& address : items_of(host, "addresses"))
      addresses.append(addresses.empty() ? "" : " ").append(address.as_string());
    host["address_list"] = addresses;
    hosts.push_back(std::move(host));
  }
  return hosts;
}

json::array programs_of(const json::array& hosts) {
  json::array programs;
  for (const json::object& host : objects(hosts))
    for (json::object program : objects(items_of(host, "programs"))) {
      program["host"] = text_at(host, "name");
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
  text += render_items(hosts, kHosts, look) + "\n";
  if (const auto lines = items_of(fleet, "lines"); !lines.empty())
    text += render_items(lines, kLines, look);
  const json::array programs = programs_of(hosts);
  return text + "\n" + render_items(programs, kPrograms, look);
}

json::object fleet_state(const std::string& name) {
  json::object fleet = sim::read_state(name);
  fleet["name"] = name;
  fleet["state"] = sim::running_fleets().is_running(name) ? "running" : "crashed";
  return fleet;
}

std::vector<std::string> names_in(const json::object& fleet, std::string_view list) {
  std::vector<std::string> names;
  for (const json::object& item : objects(items_of(fleet, list)))
    names.push_back(text_at(item, "name"));
  return names;
}

std::vector<std::string> fault_arguments() {
  std::vector<std::string> arguments = {"cut", "heal", "direction=up", "direction=down"};
  for (const auto& [name, quality] : sim::built_in_profiles()) arguments.push_back(name);
  for (const std::string_view key : sim::quality_keys())
    arguments.push_back(std::string(key) + "=");
  return arguments;
}

constexpr std::string_view kAll = "all";

sim::Quality need_quality(const std::vector<std::string>& arguments) {
  for (const std::string& argument : arguments) {
    if (argument == "cut")
      throw usage_error("a router cannot cut a line", "use blackout, which loses all datagrams");
    if (argument.starts_with("direction="))
      throw usage_error("a router applies faults only to datagrams that it sends",
                        "ask the router at the other end for the other direction");
  }
  const auto state = sim::changed({}, {}, arguments, sim::built_in_profiles());
  if (!state) throw usage_error(state.error().detail());
  return state->up;
}

Exit sim_up(Context& context) {
  sim::Plan plan =
      sim::make_plan(read_fleet_file(context),
                     context.options.insecure ? sim::Trust::kEverybody : sim::Trust::kKeys);
  plan.programs_folder = std::filesystem::path(context.options.arguments.front()).parent_path();
  sim::need_root();
  return run_service(
      context, plan.folder + "/log",
      fmt::format("fleet {} is up: `timsctl sim show`, `timsctl sim exec base "
                  "timsctl status`, `timsctl sim fault {} cut`",
                  plan.name, plan.lines.front().name),
      [&](const std::function<void()>& ready) { return run_fleet(context, plan, ready); });
}

Exit sim_down(Context& context) {
  sim::need_root();
  std::vector<std::string> names = context.options.arguments;
  if (names.empty() && !context.options.fleet.empty()) names.push_back(context.options.fleet);
  if (names.empty()) names = sim::fleets();
  bool found = false;
  for (const std::string& name : names) {
    if (!sim::is_fleet_name(name))
      throw usage_error(fmt::format("\"{}\" is not a fleet name", name), "`timsctl sim show`");
    const bool runs = sim::running_fleets().is_running(name);
    if (runs)
      (void)sim::running_fleets().ask(name, {{"do", "down"}}, context.signals, kServiceAnswers);
    const bool left = !runs && sim::clean_up(name);
    if (runs || left)
      context.out.note(fmt::format("fleet {}: {}", name, runs ? "down" : "leftovers removed"));
    found = found || runs || left;
  }
  if (context.out.json())
    context.out.write(json::object{{"schema", "tims/sim_done/1"}, {"done", found}});
  if (found || context.options.arguments.empty()) return Exit::kDone;
  throw Failure(Exit::kNoSuch, "no_such_fleet",
                fmt::format("there is no fleet {} and no remains of it", names.front()),
                "`timsctl sim show`");
}

// sim fault --link: faults applied by a router, outside of a simulated fleet

Exit link_fault(Context& context) {
  const sim::Quality quality = need_quality(context.options.arguments);
  const std::string& name = context.options.link;
  const auto connection = context.connect();
  AdminClient admin = context.admin(*connection);
  const json::object answer = admin.ask(sim::all_faults(name == kAll ? "" : name, quality));
  if (context.out.json())
    context.out.write(answer);
  else
    context.out.note(fmt::format("{}, datagrams to {}: {}", text_at(answer, "router"),
                                 name == kAll ? "everybody" : name, sim::to_string(quality)));
  return Exit::kDone;
}

Exit sim_fault(Context& context) {
  if (!context.options.link.empty()) return link_fault(context);
  const auto& arguments = context.options.arguments;
  if (arguments.size() < 2)
    throw usage_error(
        fmt::format("the fault for {} is missing", arguments.front()),
        "such as `timsctl sim fault LINE loss=10%`; use --link NAME for a link of a router");
  json::array fault;
  for (const std::string& argument : std::span(arguments).subspan(1)) fault.emplace_back(argument);
  return ask(context, {{"do", "fault"}, {"line", arguments.front()}, {"words", std::move(fault)}});
}

Exit sim_kill(Context& context) {
  const auto& arguments = context.options.arguments;
  const std::string part = arguments.size() > 1 ? arguments[1] : "";
  return ask(context, {{"do", "kill"}, {"host", arguments.front()}, {"part", part}});
}

Exit sim_start(Context& context) {
  return ask(context, {{"do", "start"}, {"host", context.options.arguments.front()}});
}

// --- sim show and other verbs that only read the state of a fleet

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
  const json::array hosts = hosts_of(fleet);
  for (const json::object& host : objects(hosts)) {
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
  if (verb == "fault" && argument > 0) return fault_arguments();
  if (verb == "kill" && argument > 0) return {"router"};
  if (verb == "up" || argument > 0) return {};
  try {
    const json::object fleet = sim::read_state(sim::chosen_fleet(""));
    return names_in(fleet, verb == "fault" ? "lines" : "hosts");
  } catch (const Failure&) {
    return {};  // no fleet, no names
  }
}

}  // namespace
}  // namespace timsctl

int main(int argc, char** argv) {
  using namespace timsctl;
  static constexpr VerbRun kRuns[] = {
      {"up", sim_up},     {"down", sim_down},   {"show", sim_show}, {"fault", sim_fault},
      {"kill", sim_kill}, {"start", sim_start}, {"exec", sim_exec}};
  const VerbProgram program{"timsctl-sim",
                            "run a fleet of robots on this machine, in network namespaces.", kRuns,
                            sim_candidates};
  return run_program(argc, argv, program);
}
