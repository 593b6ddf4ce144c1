// timsctl sim: a fleet of robots on this machine, in network namespaces.
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "os/clock.h"
#include "tools/timsctl/commands.h"
#include "tools/timsctl/context.h"
#include "tools/timsctl/detach.h"
#include "tools/timsctl/process.h"
#include "tools/timsctl/sim/state.h"
#include "tools/timsctl/sim/supervisor.h"
#include "tools/timsctl/toml_reader.h"

namespace timsctl {

namespace {

using namespace std::chrono_literals;

// Starting and ending programs takes longer than a router's answer.
constexpr tims::Duration kFleetAnswers = 30s;

sim::Fleet read_fleet_file(Context& context) {
  const std::string& path = context.options.arguments.front();
  std::ifstream file(path);
  if (!file)
    throw Failure(Exit::kNoSuch, "no_such_file", fmt::format("{}: cannot be read", path),
                  "deploy/fleets/demo.toml is one");
  sim::FleetFile read = sim::read_fleet({path, {std::istreambuf_iterator<char>(file), {}}});
  fail_if_any(read.problems, "bad_fleet", "deploy/fleets/README.md");
  if (!context.options.fleet.empty()) {
    if (!sim::is_fleet_name(context.options.fleet))
      throw usage_error(
          fmt::format("--fleet: \"{}\" is no name: at most {} small letters and "
                      "digits",
                      context.options.fleet, sim::kFleetNameMax));
    read.fleet.name = context.options.fleet;
  }
  return std::move(read.fleet);
}

// Brought up; then `ready`, then until the end.
Exit run_fleet(Context& context, const sim::Plan& plan, const std::function<void()>& ready) {
  sim::Supervisor fleet(context, plan);
  fleet.bring_up();
  ready();
  fleet.serve(context.options.run_for ? tims::os::deadline_after(*context.options.run_for)
                                      : tims::kNever);
  return fleet.failures() == 0 ? Exit::kDone : Exit::kNo;
}

Exit ask(Context& context, const json::object& question) {
  sim::need_root();
  const std::string fleet = sim::chosen_fleet(context.options.fleet);
  const auto timeout = std::max(context.options.timeout, kFleetAnswers);
  const json::object answer = sim::ask_fleet(fleet, question, context.signals, timeout);
  if (context.out.json()) context.out.write(answer);
  if (!context.out.json() && at_path(answer, "line") != nullptr)
    context.out.note(fmt::format("{}: {}", text_at(answer, "line"), text_at(answer, "state")));
  return Exit::kDone;
}

}  // namespace

Exit sim_up(Context& context) {
  sim::Plan plan = sim::make_plan(read_fleet_file(context));
  plan.programs_folder = std::filesystem::path(context.options.arguments.front()).parent_path();
  sim::need_root();
  if (context.options.detach)
    return run_detached(plan.folder + "/log", [&](const std::function<void()>& ready) {
      return run_fleet(context, plan, ready);
    });
  return run_fleet(context, plan, [&] {
    context.out.note(
        fmt::format("fleet {} is up: `timsctl sim show`, `timsctl sim exec base "
                    "timsctl status`, `timsctl sim fault {} cut`; {}",
                    plan.name, plan.lines.front().name,
                    context.options.run_for ? "it ends by itself" : "Ctrl-C ends it"));
  });
}

Exit sim_down(Context& context) {
  sim::need_root();
  std::vector<std::string> names = context.options.arguments;
  if (names.empty() && !context.options.fleet.empty()) names.push_back(context.options.fleet);
  if (names.empty()) names = sim::fleets();
  bool found = false;
  for (const std::string& name : names) {
    if (!sim::is_fleet_name(name))
      throw usage_error(fmt::format("\"{}\" is no name of a fleet", name), "`timsctl sim show`");
    const bool runs = sim::is_running(name);
    if (runs) (void)sim::ask_fleet(name, {{"do", "down"}}, context.signals, kFleetAnswers);
    const bool left = !runs && sim::clean_up(name);
    if (runs || left)
      context.out.note(fmt::format("fleet {}: {}", name, runs ? "down" : "leftovers removed"));
    found = found || runs || left;
  }
  if (context.out.json())
    context.out.write(json::object{{"schema", "tims/sim_done/1"}, {"done", found}});
  if (found || context.options.arguments.empty()) return Exit::kDone;
  throw Failure(Exit::kNoSuch, "no_such_fleet",
                fmt::format("no fleet {}, and nothing is left of it", names.front()),
                "`timsctl sim show`");
}

Exit sim_fault(Context& context) {
  if (!context.options.link.empty()) return link_fault(context);
  const auto& arguments = context.options.arguments;
  if (arguments.size() < 2)
    throw usage_error(fmt::format("what is to happen to {}?", arguments.front()),
                      "`timsctl sim fault LINE loss=10%`; --link NAME is for a link of a router");
  json::array words;
  for (const std::string& word : std::span(arguments).subspan(1)) words.emplace_back(word);
  return ask(context, {{"do", "fault"}, {"line", arguments.front()}, {"words", std::move(words)}});
}

Exit sim_kill(Context& context) {
  const auto& arguments = context.options.arguments;
  const std::string part = arguments.size() > 1 ? arguments[1] : "";
  return ask(context, {{"do", "kill"}, {"host", arguments.front()}, {"part", part}});
}

Exit sim_start(Context& context) {
  return ask(context, {{"do", "start"}, {"host", context.options.arguments.front()}});
}

}  // namespace timsctl
