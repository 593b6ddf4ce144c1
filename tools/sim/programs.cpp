#include "tools/sim/programs.h"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <fmt/format.h>

#include "os/clock.h"
#include "os/socket.h"
#include "tools/cli/failure.h"
#include "tools/sim/supervisor.h"

namespace timsctl::sim {

namespace {

using namespace std::chrono_literals;

constexpr std::string_view kRouterPart = "router";
constexpr tims::Duration kRouterPatience = 10s;
constexpr tims::Duration kEndPatience = 2s;
constexpr tims::Duration kProgramsLookAgain = 5ms;
constexpr tims::Duration kRestartPause = 500ms;

Launch router_launch(const PlannedHost& host) {
  Launch launch{.command = {"tims-router", "--config", host.config_file()},
                .network = host.network,
                .environment = {},
                .log = host.folder + "/router.log"};
  for (const std::string& setting : host.settings)
    launch.command.insert(launch.command.end(), {"--set", setting});
  return launch;
}

Launch agent_launch(const PlannedHost& host) {
  return {.command = {"tims-agent", "--folder=" + host.files(), "--state=" + host.agent_state()},
          .network = host.network,
          .environment = environment_at(host.socket()),
          .log = host.folder + "/agent.log"};
}

Launch component_launch(const Plan& plan, const PlannedHost& host, std::size_t number) {
  return {.command = host.components[number].command,
          .network = host.network,
          .environment = environment_at(host.socket()),
          .folder = plan.programs_folder,
          .log = fmt::format("{}/component{}.log", host.folder, number + 1)};
}

std::string end_of_file(const std::string& path) {
  constexpr std::streamoff kBytes = 600;
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  file.seekg(std::max<std::streamoff>(0, file.tellg() - kBytes));
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  std::string_view end(text);
  while (end.ends_with('\n')) end.remove_suffix(1);
  return std::string(end);
}

constexpr tims::Duration kPatience = 500ms;

}  // namespace

Programs::Programs(const Plan& plan) {
  const auto add = [&](const PlannedHost& host, bool router, std::string label, Launch launch) {
    programs_.push_back({.host = &host,
                         .router = router,
                         .label = std::move(label),
                         .launch = std::move(launch),
                         .child = {},
                         .status = {},
                         .restart_at = tims::kNever});
  };
  for (const PlannedHost& host : plan.hosts) {
    add(host, true, "tims-router", router_launch(host));
    add(host, false, "tims-agent", agent_launch(host));
    for (std::size_t i = 0; i < host.components.size(); ++i)
      add(host, false, host.components[i].label, component_launch(plan, host, i));
  }
}

void Programs::start(Program& program) {
  if (program.child.runs()) return;
  program.restart_at = tims::kNever;
  try {
    program.child.start(program.launch);
  } catch (const Failure& failure) {
    throw Failure(failure.exit, failure.code,
                  fmt::format("{}: {}", program.host->name, failure.message), failure.hint);
  }
}

void Programs::await_router(Program& program, const Signals& signals) {
  const tims::Time deadline = tims::os::deadline_after(kRouterPatience);
  while (!tims::os::connect_unix(program.host->socket())) {
    const tims::Time now = tims::os::now();
    (void)signals.wait(program.child.descriptor(), now + kProgramsLookAgain);
    const auto end = program.child.take_end();
    if (!end && now < deadline) continue;
    const std::string why =
        end ? end->to_string() : std::string("it did not open its socket in time");
    throw Failure(Exit::kNo, "router_failed",
                  fmt::format("{}: tims-router did not start: {}\n{}", program.host->name, why,
                              end_of_file(program.launch.log)),
                  "`settings` of the host in the fleet file?");
  }
}

void Programs::start(const PlannedHost& host, const Signals& signals) {
  for (Program& program : programs_) {
    if (program.host != &host) continue;
    start(program);
    if (program.router) await_router(program, signals);
  }
}

void Programs::start_all(const Signals& signals) {
  for (Program& program : programs_)
    if (program.router) start(program);
  for (Program& program : programs_)
    if (program.router) await_router(program, signals);
  for (Program& program : programs_) start(program);
}

template <typename Condition>
void Programs::end(Condition concerned, int signal) {
  std::vector<Program*> all;
  std::vector<const Child*> children;
  for (Program& program : programs_)
    if (concerned(program)) {
      all.push_back(&program);
      program.restart_at = tims::kNever;
      children.push_back(&program.child);
    }
  timsctl::end_all(children, signal, kEndPatience, [&](tims::Time deadline) {
    for (Program* program : all)
      if (const auto end = program->child.take_end(deadline - tims::os::now()))
        program->status = *end;
  });
}

std::size_t Programs::kill(const PlannedHost& host, std::string_view part) {
  const auto concerned = [&](const Program& program) {
    if (program.host != &host) return false;
    if (part.empty() || program.router) return part.empty() || part == kRouterPart;
    return program.label.find(part) != std::string::npos;
  };
  std::vector<std::string_view> known;
  std::size_t killed = 0;
  bool any = false;
  bool router = false;
  for (const Program& program : programs_) {
    if (program.host == &host) known.push_back(program.label);
    if (!concerned(program)) continue;
    any = true;
    router = router || program.router;
    killed += program.child.runs() ? 1U : 0U;
  }
  if (!any) throw no_such("program", part, known);
  end(concerned, SIGKILL);
  std::error_code ignored;  // a leftover: no process listens there
  if (router) std::filesystem::remove(host.socket(), ignored);
  return killed;
}

void Programs::end_all() {
  end([](const Program& program) { return !program.router; }, SIGTERM);
  end([](const Program& program) { return program.router; }, SIGTERM);
}

std::vector<int> Programs::descriptors() const {
  std::vector<int> all;
  for (const Program& program : programs_)
    if (program.child.runs()) all.push_back(program.child.descriptor());
  return all;
}

std::vector<Programs::End> Programs::ended() {
  std::vector<End> ends;
  for (Program& program : programs_) {
    const auto end = program.child.take_end();
    if (!end) continue;
    program.status = *end;
    if (program.router) program.restart_at = tims::os::now() + kRestartPause;
    ends.push_back(
        {program.host->name, program.label, program.status, end_of_file(program.launch.log)});
  }
  return ends;
}

tims::Time Programs::next_restart() const {
  tims::Time next = tims::kNever;
  for (const Program& program : programs_) next = std::min(next, program.restart_at);
  return next;
}

std::vector<const PlannedHost*> Programs::restart_routers(tims::Time now) {
  std::vector<const PlannedHost*> hosts;
  for (Program& program : programs_) {
    if (program.restart_at > now) continue;
    start(program);
    hosts.push_back(program.host);
  }
  return hosts;
}

json::array Programs::report(const PlannedHost& host) const {
  json::array out;
  for (const Program& program : programs_) {
    if (program.host != &host) continue;
    json::object item{{"name", program.label},
                      {"state", program.child.runs() ? "running" : "ended"},
                      {"log", program.launch.log}};
    if (const auto pid = program.child.pid())
      item["pid"] = *pid;
    else
      item["end"] = program.status.to_string();
    out.push_back(std::move(item));
  }
  return out;
}

std::optional<json::object> Routers::ask(const std::string& host,
                                         const json::object& question) const {
  const PlannedHost* const planned = plan_.find_host(host);
  if (planned == nullptr) return std::nullopt;
  try {
    const auto connection = connect_local({planned->socket()}, {}, kPatience, [](const auto&) {});
    AdminClient admin(*connection, context_.signals, kPatience);
    return admin.ask(question);
  } catch (const Failure& failure) {
    context_.out.detail(fmt::format("{}: {}", host, failure.message));
    return std::nullopt;
  }
}

bool Routers::inject_faults(const std::string& host, const std::string& peer,
                            const Quality& quality) const {
  return ask(host, router_faults(peer, quality)).has_value();
}

bool Routers::is_linked(const std::string& host, const std::string& peer) const {
  const auto answer = ask(host, {{"ask", "links"}, {"link", peer}});
  if (!answer) return false;
  for (const json::object& link : objects(items_of(*answer)))
    if (text_at(link, "state") == "up") return true;
  return false;
}

}  // namespace timsctl::sim
