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
      name_(deployment.name),
      router_(deployment.router),
      key_(key_of(deployment.name, deployment.router)),
      source_(deployment.source),
      control_(listen(deployment, robots().control_socket(key_)), context.signals),
      status_(robots().folder_of(key_) + "/status.sock"),
      manager_(tims::os::ServiceManager::of_environment()) {
  forget_reports(robots().folder_of(key_));
  for (std::size_t i = 0; i < robot.components.size(); ++i)
    if (robot.components[i].host == deployment.host) add(robot, i, deployment);
  if (deployment.host.empty())
    for (const Host& host : robot.hosts) add(host, robot, deployment);
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

void Supervisor::add(const Robot& robot, std::size_t number, const Deployment& deployment) {
  const Component& component = robot.components[number];
  std::vector<std::string> environment{
      "TIMS_ROUTER=" + deployment.router, "TIMS_HOST=", "NOTIFY_SOCKET=" + status_.path(),
      "PATH=" + search_path(), "RACK_RUN=" + robots().folder_of(key_)};
  if (!robot.files.empty()) environment.push_back("RACK_FILES=" + robot.files);
  programs_.emplace_back(
      component.name,
      Launch{.command = component.command,
             .environment = std::move(environment),
             .folder = deployment.folder},
      Program::Config{.restart = component.restart, .notifies = component.notifies});
  components_[&programs_.back()] = number;
}

// On that host timsctl supervises the programs. It ends when its stdin is closed, that is, when
// this process ends or the connection breaks.
void Supervisor::add(const Host& host, const Robot& robot, const Deployment& deployment) {
  tims::os::Command command{"ssh", "-oBatchMode=yes", "--", host.ssh, "timsctl"};
  if (!host.router.empty()) command.push_back("--host=" + host.router);
  for (std::string argument : {std::string("up"), std::string("-"), "--on=" + host.name,
                               fmt::format("--system={}", robot.system), std::string("--no-color")})
    command.push_back(std::move(argument));
  std::string input = deployment.source.text;
  input += '\0';
  programs_.emplace_back(
      host.name, Launch{.command = std::move(command)},
      Program::Config{.restart = Restart::kAlways, .notifies = false, .input = std::move(input)});
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
  events_.write_line("started", name_, text);
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
    return text_at(question, "do") == "save" ? save(question) : report();
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
          {"name", name_},
          {"router", router_},
          {"file", source_.file},
          {"items", std::move(items)}};
}

// Saves all changed parameters, or only the named one, of the component at an address.
json::object Supervisor::save(const json::object& question) {
  for (Program& any : programs_) (void)any.take_notifications();  // the newest parameter values
  const auto program =
      std::ranges::find(programs_, text_at(question, "address"), &Program::address);
  if (program == programs_.end() || !components_.contains(&*program))
    throw Failure(Exit::kNoSuch, "no_such_component",
                  "robot " + name_ + " does not have this component",
                  "`timsctl robot` lists its components");
  Program::Parameters parameters = program->parameters();
  if (const std::string name = text_at(question, "name"); !name.empty())
    std::erase_if(parameters, [&](const auto& parameter) { return parameter.first != name; });
  const bool dry_run = text_at(question, "dry_run") == "true";
  json::object answer = save_parameters(source_, components_.at(&*program), parameters, dry_run);
  answer["component"] = program->name();
  return answer;
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
