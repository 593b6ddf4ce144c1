#include "tools/robot/supervisor.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>

#include <fmt/format.h>
#include <unistd.h>

#include "base/measure.h"
#include "os/clock.h"
#include "os/environment.h"
#include "os/file.h"
#include "os/process.h"
#include "os/socket.h"
#include "os/wakeup.h"
#include "tools/cli/failure.h"

namespace timsctl::robot {

namespace {

// A folder that only this user can write.
std::string all_robots() {
  if (const std::string runtime = tims::os::environment("XDG_RUNTIME_DIR"); !runtime.empty())
    return runtime + "/tims-robots";
  if (::geteuid() == 0) return "/run/tims-robots";
  return fmt::format("/tmp/tims-robots-{}", ::geteuid());
}

}  // namespace

std::string key_of(std::string_view name, std::string_view router) {
  std::uint32_t hash = 2166136261;  // FNV-1a
  for (const char c : router) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619;
  return fmt::format("{}@{:08x}", name, hash);
}

const Services& robots() {
  static const Services kRobots(
      "robot", all_robots(),
      {.none = "`timsctl up FILE` starts one",
       .not_running = "`timsctl up FILE` starts one",
       .several = "name one: `timsctl down NAME`, with the same -H as its `up`"});
  return kRobots;
}

std::string log_file(std::string_view key) { return robots().folder_of(key) + "/log"; }

std::string chosen(std::string_view name, std::string_view router) {
  std::vector<std::string> found;
  for (std::string& key : robots().running()) {
    if (key == name || key == key_of(name, router)) return key;
    if (name.empty() || name == name_of(key)) found.push_back(std::move(key));
  }
  if (found.empty() && !name.empty())
    throw robots().not_running(name, "`timsctl robot` lists running robots");
  return robots().only_one(found);
}

namespace {

using namespace std::chrono_literals;

constexpr tims::Duration kStartPatience = 10s;  // the router may have to start first
constexpr tims::Duration kEndPatience = 5s;

constexpr std::size_t kStatusMax = 120;  // of 200 programs in one answer
constexpr int kDatagramsPerTurn = 64;    // of programs that are no components

// They come and go.
std::vector<int> descriptors_of(const std::list<Program>& programs, tims::Time now) {
  std::vector<int> all;
  for (const Program& program : programs)
    for (const int descriptor : program.descriptors(now)) all.push_back(descriptor);
  return all;
}

tims::Time look_again_at(const std::list<Program>& programs, tims::Time now) {
  tims::Time next = tims::kNever;
  for (const Program& program : programs) next = std::min(next, program.look_again_at(now));
  return next;
}

// Whether the program, or one that it has started, has this process id.
bool has_sent(const Program& program, pid_t sender) {
  const auto pid = program.child().pid();
  return pid && (*pid == sender || ::getpgid(sender) == *pid);
}

tims::os::File listen(const Deployment& deployment, const std::string& path) {
  auto control = tims::os::listen_unix(path, 0600);
  if (!control && control.error().code() == tims::Errc::kAddressInUse)
    throw Failure(
        Exit::kDenied, "robot_runs",
        fmt::format("robot {} is already running at {}", deployment.name, deployment.router),
        fmt::format("`timsctl down {}` stops it", deployment.name));
  return value_or_fail(std::move(control), path);
}

// A program started by a command (`nice World`) is searched where find_program() would find it.
std::string search_path() {
  const std::string usual = tims::os::environment("PATH");
  const auto own = std::filesystem::path(tims::os::find_program("timsctl")).parent_path();
  return fmt::format("{}:{}", own.string(), usual.empty() ? "/usr/bin:/bin" : usual);
}

// Remarks that the programs of a robot make once in a run (components/runtime/robot_run.h).
void forget_reports(const std::string& folder) {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
    if (entry.path().filename().string().starts_with("reported-"))
      std::filesystem::remove(entry.path(), ignored);
}

// Whether the other end of the pipe is closed.
bool has_closed(int input) {
  std::array<char, 256> ignored{};
  return tims::os::is_readable(input) && ::read(input, ignored.data(), ignored.size()) <= 0;
}

}  // namespace

Supervisor::Supervisor(Context& context, const Robot& robot, const Deployment& deployment)
    : context_(context),
      events_(context, "tims/robot_event/1", 20),
      robot_(robot),
      deployment_(deployment),
      key_(key_of(deployment.name, deployment.router)),
      control_(listen(deployment, robots().control_socket(key_)), context.signals),
      status_(robots().folder_of(key_) + "/status.sock"),
      manager_(tims::os::ServiceManager::of_environment()) {
  forget_reports(robots().folder_of(key_));
  for (std::size_t i = 0; i < robot.components.size(); ++i)
    if (robot.components[i].host == deployment.host) (void)add(i);
  if (deployment.host.empty())
    for (const Host& host : robot.hosts) (void)add(host);
}

Supervisor::~Supervisor() {
  try {
    end_all();
  } catch (const std::exception&) {
    // The reader of stdout has closed it; the programs must be stopped nevertheless.
    for (const Program& program : programs_) program.child().signal(SIGKILL);
  }
  control_.end({{"schema", "tims/robot_done/1"}, {"done", true}});
}

Program& Supervisor::add(std::size_t number) {
  const Component& component = robot_.components[number];
  std::vector<std::string> environment{
      "TIMS_ROUTER=" + deployment_.router, "TIMS_HOST=", "NOTIFY_SOCKET=" + status_.path(),
      "PATH=" + search_path(), "RACK_RUN=" + robots().folder_of(key_)};
  if (!robot_.files.empty()) environment.push_back("RACK_FILES=" + robot_.files);
  programs_.emplace_back(
      component.name,
      Launch{.command = component.command,
             .environment = std::move(environment),
             .folder = deployment_.folder},
      Program::Config{.restart = component.restart, .notifies = component.notifies});
  components_[&programs_.back()] = number;
  return programs_.back();
}

// On that host timsctl supervises the programs. It ends when its stdin is closed, that is, when
// this process ends or the connection breaks.
Program& Supervisor::add(const Host& host) {
  tims::os::Command command{"ssh", "-oBatchMode=yes", "--", host.ssh, "timsctl"};
  if (!host.router.empty()) command.push_back("--host=" + host.router);
  for (std::string argument :
       {std::string("up"), std::string("-"), "--on=" + host.name,
        fmt::format("--system={}", robot_.system), std::string("--no-color")})
    command.push_back(std::move(argument));
  std::string input = deployment_.source.text;
  input += '\0';
  programs_.emplace_back(
      host.name, Launch{.command = std::move(command)},
      Program::Config{.restart = Restart::kAlways, .notifies = false, .input = std::move(input)});
  return programs_.back();
}

void Supervisor::start() {
  events_.begin();
  for (Program& program : programs_) program.start(tims::os::now());
  const tims::Time deadline = events_.began() + kStartPatience;
  while (is_starting() && !control_.asked_to_end() && tims::os::now() < deadline) {
    wait(std::min(deadline, next_start()));
    look_after_programs();
  }
  const std::vector<std::string> down = names(State::kDown);
  const std::vector<std::string> late = names(State::kStarting);
  std::string text = fmt::format("{} of {} programs are ready",
                                 programs_.size() - down.size() - late.size(), programs_.size());
  if (!late.empty()) text += fmt::format(", {} not yet: {}", late.size(), fmt::join(late, ", "));
  if (!down.empty()) text += fmt::format(", {} ended: {}", down.size(), fmt::join(down, ", "));
  events_.write_line("started", deployment_.name, text);
}

void Supervisor::serve(tims::Time until, int input) {
  manager_.report("READY", "1");
  while (!control_.asked_to_end() && tims::os::now() < until) {
    const bool reported = manager_.flush();
    const tims::Time next =
        reported ? next_start() : tims::os::now() + tims::os::ServiceManager::kFlushPause;
    wait(std::min(until, next), input);
    look_after_programs();
    if (has_closed(input)) return;
  }
}

bool Supervisor::is_starting() const {
  return std::ranges::any_of(programs_, [](const Program& program) {
    return program.state() == State::kStarting || program.start_at() != tims::kNever;
  });
}

std::vector<std::string> Supervisor::names(State state) const {
  std::vector<std::string> all;
  for (const Program& program : programs_)
    if (program.state() == state) all.push_back(program.name());
  return all;
}

tims::Time Supervisor::next_start() const {
  tims::Time next = tims::kNever;
  for (const Program& program : programs_) next = std::min(next, program.start_at());
  return next;
}

void Supervisor::wait(tims::Time deadline, int input) {
  const tims::Time now = tims::os::now();
  std::vector<int> descriptors = descriptors_of(programs_, now);
  descriptors.insert(descriptors.end(), {status_.descriptor(), input});
  deadline = std::min({deadline, look_again_at(programs_, now), events_.flush_at()});
  control_.wait(std::move(descriptors), deadline);
}

// In each turn, a bounded amount is read from every program.
void Supervisor::look_after_programs() {
  control_.take_question([&](const json::object& question) {
    const std::string what = text_at(question, "do");
    if (what == "reload") return reload();
    return what == "save" ? save(question) : report();
  });
  take_notifications();
  for (Program& program : programs_) look_after(program);
  events_.flush();
  if (context_.options.detach) keep_log_short(log_file(key_));
}

void Supervisor::look_after(Program& program) {
  const tims::Time now = tims::os::now();
  if (program.take_notifications()) report_state(program);
  const auto end = program.ended(now);
  write_lines(program, now);
  if (end) take_end(program, *end);
  if (program.start_at() <= now) start_again(program, now);
}

void Supervisor::write_lines(Program& program, tims::Time now) {
  for (const std::string& line : program.take_lines(now))
    events_.write_line("said", program.name(), line);
}

// A program that cannot be executed may just be being installed: it is tried again.
void Supervisor::start_again(Program& program, tims::Time now) {
  try {
    program.start(now);
    events_.write_line("restarted", program.name(), "restarted");
  } catch (const Failure& failure) {
    take_end(program, program.could_not_start(now));
    events_.write_line("said", program.name(), failure.message);
  }
}

void Supervisor::take_end(Program& program, const Program::End& end) {
  const std::string how = end.status.to_string();
  ends_[&program] = how;
  if (end.pause && !ending_)
    return events_.write_line("ended", program.name(),
                              fmt::format("{}: restart in {:g} s", how, base::seconds(*end.pause)));
  program.stay_down();
  if (ending_) return events_.write_line("ended", program.name(), how);
  if (!end.status.success()) ++failures_;
  events_.write_line("ended", program.name(), how + ": not restarted");
}

void Supervisor::take_notifications() {
  for (int taken = 0; taken < kDatagramsPerTurn; ++taken) {
    const auto notification = status_.take();
    if (!notification) return;
    const auto program = std::ranges::find_if(
        programs_, [&](const Program& any) { return has_sent(any, notification->pid); });
    if (program == programs_.end()) continue;
    program->on_notification(notification->text);
    report_state(*program);
  }
}

// The status is shown by `timsctl robot`.
void Supervisor::report_state(const Program& program) {
  if (!program.status().empty() && context_.out.json())
    events_.write_line("state", program.name(), program.status());
}

// The status that a program has reported means nothing when the program has ended.
std::string Supervisor::status_of(const Program& program) const {
  if (program.state() == State::kStarting && program.status().empty()) return "starting";
  const bool silent = program.status().empty();  // a component that has not been turned on yet
  if (program.state() != State::kDown && silent)
    return program.address().empty() ? "running" : "off";
  if (program.state() != State::kDown) return program.status();
  const auto how = ends_.find(&program);
  const std::string dead = how == ends_.end() ? "dead" : "dead: " + how->second;
  if (program.start_at() == tims::kNever) return dead + ", not restarted";
  const auto left = std::max(program.start_at() - tims::os::now(), tims::Duration{});
  return fmt::format("{}, restart in {:.1f} s", dead, base::seconds(left));
}

json::object Supervisor::report() const {
  json::array items;
  for (const Program& program : programs_) {
    json::object item{{"name", program.name()},
                      {"status", status_of(program).substr(0, kStatusMax)}};
    if (const auto pid = program.child().pid()) item["pid"] = *pid;
    if (!program.address().empty()) item["address"] = program.address();
    if (const auto component = component_of(program.command())) item["component"] = *component;
    items.push_back(std::move(item));
  }
  return {{"schema", "tims/robot/1"},
          {"name", deployment_.name},
          {"router", deployment_.router},
          {"file", deployment_.source.file},
          {"items", std::move(items)}};
}

// Saves all changed parameters, or only the named one, of the component at an address.
json::object Supervisor::save(const json::object& question) {
  for (Program& any : programs_) (void)any.take_notifications();  // the newest parameter values
  const auto program =
      std::ranges::find(programs_, text_at(question, "address"), &Program::address);
  if (program == programs_.end() || !components_.contains(&*program))
    throw Failure(Exit::kNoSuch, "no_such_component",
                  "robot " + deployment_.name + " does not have this component",
                  "`timsctl robot` lists its components");
  Program::Parameters parameters = program->parameters();
  if (const std::string name = text_at(question, "name"); !name.empty())
    std::erase_if(parameters, [&](const auto& parameter) { return parameter.first != name; });
  const bool dry_run = text_at(question, "dry_run") == "true";
  json::object answer =
      save_parameters(deployment_.source, components_.at(&*program), parameters, dry_run);
  answer["component"] = program->name();
  return answer;
}

namespace {

std::string text_of_file(const RobotText& source) {
  if (source.file.empty())
    throw Failure(Exit::kNoSuch, "no_robot_file",
                  "this robot was not read from a file on this host",
                  "reload on the host where `timsctl up FILE` runs");
  auto text = tims::os::read_file(source.file);
  if (!text)
    throw Failure(Exit::kNoSuch, "no_robot_file", text.error().detail(), "has it been moved?");
  return std::move(*text);
}

const Component* find(const Robot& robot, const std::string& name) {
  const auto found = std::ranges::find(robot.components, name, &Component::name);
  return found == robot.components.end() ? nullptr : &*found;
}

// Whether the components of this other host, or the way to it, have changed.
bool has_changed(const Robot& before, const Robot& after, const std::string& host) {
  const auto of_host = [&](const Robot& robot) {
    std::vector<Component> all;
    std::ranges::copy_if(robot.components, std::back_inserter(all),
                         [&](const Component& each) { return each.host == host; });
    return all;
  };
  const auto way = [&](const Robot& robot) {
    const auto found = std::ranges::find(robot.hosts, host, &Host::name);
    return found == robot.hosts.end() ? std::string() : found->ssh + " " + found->router;
  };
  return way(before) != way(after) || of_host(before) != of_host(after);
}

}  // namespace

// Reads the robot file again: programs whose command, restart or host has changed are restarted,
// new ones started, those no longer in the file stopped; all others run on.
json::object Supervisor::reload() {
  const std::string text = text_of_file(deployment_.source);
  RobotFile read =
      read_robot({deployment_.source.file, text}, robot_.name, deployment_.source.system);
  fail_if_any(read.problems, "bad_robot", "the robot runs on as it was");
  if (read.robot.name != robot_.name || read.robot.system != robot_.system ||
      read.robot.files != robot_.files)
    throw Failure(Exit::kNo, "needs_restart",
                  "a robot with another name, system or folder of files is another robot",
                  "`timsctl down` and `timsctl up`");
  std::swap(robot_, read.robot);
  const Robot& before = read.robot;
  deployment_.source.text = text;
  std::vector<Program*> gone;
  json::array items;
  const auto note = [&](const std::string& name, std::string_view does) {
    items.push_back(json::object{{"name", name}, {"does", does}});
  };
  std::vector<std::string> kept;
  for (Program& program : programs_) {
    const bool is_component = components_.contains(&program);
    const Component* now = is_component ? find(robot_, program.name()) : nullptr;
    const bool stays = is_component ? now != nullptr && *now == *find(before, program.name())
                                    : !has_changed(before, robot_, program.name());
    if (!stays) {
      gone.push_back(&program);
      continue;
    }
    kept.push_back(program.name());
    if (is_component)
      components_[&program] = static_cast<std::size_t>(now - robot_.components.data());
  }
  std::vector<std::string> ended;
  ended.reserve(gone.size());
  for (const Program* program : gone) ended.push_back(program->name());
  end(gone);
  const auto is_in = [](const std::vector<std::string>& names, const std::string& name) {
    return std::ranges::find(names, name) != names.end();
  };
  const auto start = [&](Program& program) {
    start_again(program, tims::os::now());
    note(program.name(), is_in(ended, program.name()) ? "restart" : "start");
    std::erase(ended, program.name());
  };
  for (std::size_t i = 0; i < robot_.components.size(); ++i)
    if (robot_.components[i].host == deployment_.host && !is_in(kept, robot_.components[i].name))
      start(add(i));
  if (deployment_.host.empty())
    for (const Host& host : robot_.hosts)
      if (!is_in(kept, host.name)) start(add(host));
  for (const std::string& name : ended) note(name, "stop");
  events_.write_line("reloaded", deployment_.name,
                     fmt::format("{} of {} programs were changed", items.size(), programs_.size()));
  return {{"schema", "tims/robot_reload/1"}, {"items", std::move(items)}};
}

// Stops these programs and forgets them.
void Supervisor::end(const std::vector<Program*>& gone) {
  std::vector<const Child*> children;
  for (Program* program : gone) {
    program->stay_down();
    children.push_back(&program->child());
  }
  ending_ = true;  // their ends are no failures
  timsctl::end_all(children, SIGTERM, kEndPatience, [&](tims::Time deadline) {
    std::vector<int> descriptors;
    for (const Program* program : gone)
      for (const int each : program->descriptors(tims::os::now())) descriptors.push_back(each);
    const auto any = tims::os::any_of(descriptors);
    (void)tims::os::is_readable(any ? any->get() : -1, deadline - tims::os::now());
    for (Program* program : gone) look_after(*program);
    events_.flush();
  });
  ending_ = false;
  for (const Program* program : gone) {
    ends_.erase(program);
    components_.erase(program);
    programs_.remove_if([&](const Program& each) { return &each == program; });
  }
}

void Supervisor::end_all() {
  ending_ = true;
  std::vector<const Child*> children;
  for (const Program& program : programs_) children.push_back(&program.child());
  timsctl::end_all(children, SIGTERM, kEndPatience, [&](tims::Time deadline) {
    const tims::Time now = tims::os::now();
    const auto any = tims::os::any_of(descriptors_of(programs_, now));
    deadline = std::min({deadline, look_again_at(programs_, now), events_.flush_at()});
    (void)tims::os::is_readable(any ? any->get() : -1, deadline - now);
    for (Program& program : programs_) look_after(program);
    events_.flush();
  });
  // What is still in their pipes, which hold 64 KiB.
  constexpr int kLastTurns = 5;
  tims::Time now = tims::os::now();
  for (int turn = 0; turn < kLastTurns; ++turn, now += kReadPause)
    for (Program& program : programs_) write_lines(program, now);
}

}  // namespace timsctl::robot
