#include "tools/sim/supervisor.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <unistd.h>

#include "base/measure.h"
#include "os/clock.h"
#include "os/file.h"
#include "os/process.h"
#include "os/socket.h"
#include "tools/sim/fleet_keys.h"
#include "tools/sim/host_files.h"

namespace timsctl::sim {

namespace {

namespace fs = std::filesystem;

// "demo" for "tims-demo-base"; empty for names of other programs.
std::string fleet_of_network(std::string_view network) {
  constexpr std::string_view kPrefix = "tims-";
  if (!network.starts_with(kPrefix)) return {};
  network.remove_prefix(kPrefix.size());
  const std::size_t dash = network.find('-');
  const std::string name(network.substr(0, dash));
  return dash != std::string_view::npos && is_fleet_name(name) ? name : std::string();
}

}  // namespace

const Services& running_fleets() {
  static const Services kFleets(
      "fleet", std::string(kSimFolder),
      {.none = "`timsctl sim up FILE` starts one, as root",
       .not_running = "`timsctl sim up FILE` starts one; `timsctl sim show` lists all",
       .several = "select one with --fleet NAME"});
  return kFleets;
}

std::vector<std::string> fleets() {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(kSimFolder, ignored))
    if (is_fleet_name(entry.path().filename().string())) names.push_back(entry.path().filename());
  for (const auto& entry : fs::directory_iterator("/run/netns", ignored))
    if (std::string name = fleet_of_network(entry.path().filename().string()); !name.empty())
      names.push_back(std::move(name));
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

json::object read_state(std::string_view fleet) {
  return parse_object(
      tims::os::read_file(running_fleets().folder_of(fleet) + "/state.json").value_or({}));
}

void write_state(std::string_view fleet, const json::object& state) {
  const std::string path = running_fleets().folder_of(fleet) + "/state.json";
  std::ofstream(path + ".new") << to_text(state) << '\n';
  std::error_code ignored;  // atomic: readers see the complete old or new file
  fs::rename(path + ".new", path, ignored);
}

bool clean_up(std::string_view fleet) {
  const auto networks = networks_of(fleet);
  remove_networks(networks);
  std::error_code ignored;
  const auto files = fs::remove_all(running_fleets().folder_of(fleet), ignored);
  return !networks.empty() || (files != 0 && files != static_cast<std::uintmax_t>(-1));
}

std::string chosen_fleet(std::string_view name) {
  if (!name.empty()) {
    if (!is_fleet_name(name))
      throw usage_error(fmt::format("\"{}\" is not a fleet name", name), "`timsctl sim show`");
    return std::string(name);
  }
  return running_fleets().only_one(running_fleets().running());
}

Failure no_such(std::string_view what, std::string_view name,
                std::span<const std::string_view> known) {
  return {Exit::kNoSuch, fmt::format("no_such_{}", what), fmt::format("no {} \"{}\"", what, name),
          nearest_hint(name, known)};
}

void need_root() {
  if (::geteuid() == 0) return;
  throw Failure(Exit::kDenied, "denied", "creating network namespaces requires root",
                "sudo timsctl sim ...");
}

namespace {

using namespace std::chrono_literals;

constexpr tims::Duration kInjectAgain = 200ms;  // until the link exists
constexpr tims::Duration kLinksPatience = 5s;
constexpr tims::Duration kSupervisorLookAgain = 20ms;

std::string joined(const tims::os::Command& command) {
  return fmt::format("{}", fmt::join(command, " "));
}

// The action that undoes a fault after `for`; empty: there is none.
tims::os::Command undoing(const Step& step) {
  if (!step.host.empty()) return {step.arguments.front() == "kill" ? "start" : "kill"};
  return {"heal"};
}

template <typename Item>
const Item& need(std::string_view what, std::string_view name, const std::vector<Item>& items) {
  const auto found = std::ranges::find(items, name, &Item::name);
  if (found != items.end()) return *found;
  std::vector<std::string_view> known(items.size());
  std::ranges::transform(items, known.begin(), &Item::name);
  throw no_such(what, name, known);
}

// Reserves the name of the fleet.
tims::os::File listen(const Context& context, const Plan& plan) {
  if (running_fleets().is_running(plan.name))
    throw Failure(Exit::kDenied, "fleet_runs",
                  fmt::format("fleet {} is already running", plan.name),
                  fmt::format("`timsctl sim down {}` stops it; --fleet NAME gives this one another "
                              "name",
                              plan.name));
  if (clean_up(plan.name))
    context.out.note(fmt::format("fleet {}: removed the remains of a crash", plan.name));
  return value_or_fail(tims::os::listen_unix(running_fleets().control_socket(plan.name), 0600),
                       plan.folder);
}

}  // namespace

Supervisor::Supervisor(Context& context, const Plan& plan)
    : context_(context),
      events_(context, "tims/sim_event/1", 14),
      plan_(plan),
      network_(plan),
      programs_(plan),
      routers_(context, plan),
      control_(listen(context, plan), context.signals) {
  since_ = base::rfc3339(tims::os::wall_now());
  for (const Line& line : plan.lines) states_[line.name] = line.own;
}

Supervisor::~Supervisor() {
  try {
    tear_down();
  } catch (const std::exception& error) {
    context_.out.note(fmt::format("fleet {}: {}; `timsctl sim down {}` tries again", plan_.name,
                                  error.what(), plan_.name));
  }
}

void Supervisor::write_files() const {
  for (const PlannedHost& host : plan_.hosts) write_host_files(host, plan_.programs_folder);
  if (plan_.trust == Trust::kKeys) make_keys(plan_);
}

void Supervisor::write_state() const {
  json::array hosts;
  for (const PlannedHost& host : plan_.hosts) {
    json::array addresses;
    for (const std::string& address : host.addresses) addresses.emplace_back(address);
    hosts.push_back(json::object{{"name", host.name},
                                 {"network", host.network},
                                 {"role", host.role},
                                 {"system", host.system},
                                 {"addresses", std::move(addresses)},
                                 {"router", host.socket()},
                                 {"programs", programs_.report(host)}});
  }
  json::array lines;
  for (const Line& line : plan_.lines)
    lines.push_back(json::object{{"name", line.name},
                                 {"upper", line.upper.host},
                                 {"lower", line.lower.host},
                                 {"state", to_string(states_.find(line.name)->second)}});
  sim::write_state(plan_.name, {{"schema", "tims/sim/1"},
                                {"name", plan_.name},
                                {"pid", ::getpid()},
                                {"since", since_},
                                {"folder", plan_.folder},
                                {"netem", network_.netem()},
                                {"hosts", std::move(hosts)},
                                {"lines", std::move(lines)}});
}

void Supervisor::bring_up() {
  write_files();
  write_state();
  network_.make();
  events_.write_line(
      "network", plan_.name,
      fmt::format("{} hosts and {} lines{}", plan_.hosts.size(), plan_.lines.size(),
                  network_.netem() ? "" : "; no netem: the routers delay, duplicate and reorder"));
  programs_.start_all(context_.signals);
  std::size_t components = 0;
  for (const PlannedHost& host : plan_.hosts) components += host.components.size();
  events_.write_line("started", plan_.name,
                     fmt::format("{} routers and {} components", plan_.hosts.size(), components));
  for (const Line& line : plan_.lines) {
    request_faults(line, {}, line.own);
    if (line.own != LineState()) events_.write_line("line", line.name, to_string(line.own));
  }
  await_links();
  start_clock();
  write_state();
}

// Waits for the links that can come up. A link that does not is reported; it is not an error,
// because the scenario may intend it.
void Supervisor::await_links() {
  std::vector<const Line*> open;
  for (const Line& line : plan_.lines)
    if (!line.own.up.blackout && !line.own.down.blackout) open.push_back(&line);
  const std::size_t all = open.size();
  const tims::Time deadline = tims::os::deadline_after(kLinksPatience);
  for (;;) {
    std::erase_if(open, [&](const Line* line) {
      return routers_.is_linked(line->lower.host, line->upper.host);
    });
    if (open.empty() || tims::os::now() > deadline) break;
    context_.signals.sleep_until(tims::os::now() + kSupervisorLookAgain);
  }
  events_.write_line("linked", plan_.name,
                     fmt::format("{} of {} links are up", all - open.size(), all));
  for (const Line* line : open)
    events_.write_line("not_linked", line->name, "its link did not come up");
  inject_pending_faults();
}

void Supervisor::start_clock() {
  events_.begin();
  for (const Step& step : plan_.steps) {
    const tims::Time at = events_.began() + step.at;
    schedule_.emplace(at, Action{step.line, step.host, step.arguments, step.every});
    if (step.duration)
      schedule_.emplace(at + *step.duration,
                        Action{step.line, step.host, undoing(step), step.every});
  }
}

void Supervisor::tear_down() {
  programs_.end_all();
  clean_up(plan_.name);
  control_.end({{"schema", "tims/sim_done/1"}, {"done", true}});
}

// --- changes of lines and hosts

void Supervisor::fault(const Line& line, const tims::os::Command& arguments) {
  LineState& state = states_[line.name];
  const auto next = changed(state, line.own, arguments, plan_.profiles);
  if (!next) throw usage_error(fmt::format("{}: {}", line.name, next.error().detail()));
  network_.apply(line, state, *next);
  request_faults(line, state, *next);
  state = *next;
  inject_pending_faults();
  const std::string requested = joined(arguments);
  const std::string is = to_string(state);
  events_.write_line("fault", line.name,
                     requested == is ? is : fmt::format("{}: {}", requested, is));
  write_state();
}

void Supervisor::kill(const PlannedHost& host, std::string_view part) {
  const std::size_t count = programs_.kill(host, part);
  events_.write_line("kill", host.name,
                     count == 0 ? "no program was running"
                                : fmt::format("{}{}killed", part, part.empty() ? "" : " "));
  write_state();
}

void Supervisor::start(const PlannedHost& host) {
  programs_.start(host, context_.signals);
  request_all_faults(host);
  events_.write_line("start", host.name, "started");
  write_state();
}

void Supervisor::act(const Action& action) {
  if (!action.line.empty()) return fault(need_line(action.line), action.arguments);
  const PlannedHost& host = need_host(action.host);
  action.arguments.front() == "kill" ? kill(host, "") : start(host);
}

void Supervisor::request_faults(const Line& line, const LineState& before, const LineState& state) {
  if (network_.netem()) return;
  if (needs_router(before.up) || needs_router(state.up))
    pending_faults_[{line.lower.host, line.upper.host}] = state.up;
  if (needs_router(before.down) || needs_router(state.down))
    pending_faults_[{line.upper.host, line.lower.host}] = state.down;
}

// A router that is new knows nothing; neither does its neighbour of the new router.
void Supervisor::request_all_faults(const PlannedHost& host) {
  for (const Line& line : plan_.lines)
    if (line.upper.host == host.name || line.lower.host == host.name)
      request_faults(line, {}, states_[line.name]);
}

void Supervisor::inject_pending_faults() {
  std::erase_if(pending_faults_, [&](const auto& fault) {
    return routers_.inject_faults(fault.first.first, fault.first.second, fault.second);
  });
  next_injection_ = tims::os::now() + kInjectAgain;
}

// --- the loop

tims::Time Supervisor::next_deadline(tims::Time until) const {
  tims::Time next = std::min(until, programs_.next_restart());
  if (!schedule_.empty()) next = std::min(next, schedule_.begin()->first);
  if (!pending_faults_.empty()) next = std::min(next, next_injection_);
  return next;
}

void Supervisor::serve(tims::Time until) {
  while (!control_.asked_to_end() && tims::os::now() < until) {
    control_.wait(programs_.descriptors(), std::min(next_deadline(until), events_.flush_at()));
    events_.flush();
    look_after_programs();
    restart_routers();
    control_.take_question([&](const json::object& question) { return answer(question); });
    while (!schedule_.empty() && schedule_.begin()->first <= tims::os::now()) {
      const auto [at, action] = *schedule_.begin();
      schedule_.erase(schedule_.begin());
      if (action.every) schedule_.emplace(at + *action.every, action);
      act(action);
    }
    if (!pending_faults_.empty() && next_injection_ <= tims::os::now()) inject_pending_faults();
  }
}

void Supervisor::look_after_programs() {
  for (const Programs::End& end : programs_.ended()) {
    if (!end.status.success()) ++failures_;
    events_.write_line("ended", end.host,
                       fmt::format("{}: {}{}{}", end.label, end.status.to_string(),
                                   end.stop_commands.empty() ? "" : "\n", end.stop_commands));
    write_state();
  }
}

void Supervisor::restart_routers() {
  for (const PlannedHost* host : programs_.restart_routers(tims::os::now())) {
    request_all_faults(*host);
    events_.write_line("start", host->name, "its router is started again");
    write_state();
  }
}

json::object Supervisor::answer(const json::object& question) {
  const std::string what = text_at(question, "do");
  if (what == "fault") {
    tims::os::Command arguments;
    for (const json::value& argument : items_of(question, "words"))
      arguments.emplace_back(argument.as_string());
    const Line& line = need_line(text_at(question, "line"));
    fault(line, arguments);
    return {{"schema", "tims/sim_done/1"},
            {"line", line.name},
            {"state", to_string(states_[line.name])}};
  }
  if (what == "kill") kill(need_host(text_at(question, "host")), text_at(question, "part"));
  if (what == "start") start(need_host(text_at(question, "host")));
  return {{"schema", "tims/sim_done/1"}, {"done", true}};
}

const PlannedHost& Supervisor::need_host(std::string_view name) const {
  return need("host", name, plan_.hosts);
}

const Line& Supervisor::need_line(std::string_view name) const {
  return need("line", name, plan_.lines);
}

}  // namespace timsctl::sim
