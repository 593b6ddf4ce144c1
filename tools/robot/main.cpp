// timsctl up, down and robot: the components of a robot.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>

#include <fmt/format.h>
#include <unistd.h>

#include "base/text.h"
#include "os/environment.h"
#include "tools/cli/arguments.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/cli/program.h"
#include "tools/cli/service.h"
#include "tools/robot/supervisor.h"

namespace timsctl {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFileMax = 60'000;  // with its terminator it fits into a pipe

// Reads to the end, or to a zero byte: then the writer keeps stdin open as long as the robot shall
// run.
std::string read_text(std::istream& file, const std::string& name) {
  std::string text(kFileMax + 2, '\0');
  file.getline(text.data(), std::ssize(text), '\0');
  if (file.gcount() == 0)
    throw Failure(Exit::kNoSuch, "no_such_file", fmt::format("cannot read {}", name),
                  "see deploy/robots/sim.toml for an example");
  text.resize(text.find('\0'));
  if (text.size() > kFileMax)
    throw Failure(Exit::kNo, "bad_robot", fmt::format("{}: larger than {} bytes", name, kFileMax));
  return text;
}

struct UpRequest {
  robot::Robot robot;
  robot::Deployment deployment;
  bool held = false;  // the robot runs only as long as the writer keeps stdin open
};

// Programs run in another folder than timsctl, so the path is made absolute.
std::string absolute(Host host) {
  if (auto* local = std::get_if<UnixHost>(&host)) local->path = fs::absolute(local->path);
  return to_string(host);
}

// An unknown host in --on would start nothing and wait.
void need_host(const robot::Robot& robot, const std::string& name) {
  if (name.empty()) return;
  std::vector<std::string_view> known(robot.hosts.size());
  std::ranges::transform(robot.hosts, known.begin(), &robot::Host::name);
  if (std::ranges::find(known, name) != known.end()) return;
  throw usage_error(
      fmt::format("--on: the robot has no host \"{}\"", name),
      nearest_hint(name, known,
                   known.empty() ? "define it with [host.NAME] in the robot file" : ""));
}

UpRequest read_robot_file(const Context& context) {
  const std::string& path = context.options.arguments.front();
  const bool from_stdin = path == "-";
  std::ifstream file(from_stdin ? "/dev/stdin" : path);
  UpRequest request;
  robot::Deployment& deployment = request.deployment;
  deployment.source = {.file = {}, .text = read_text(file, path), .system = context.options.system};
  deployment.host = context.options.on;
  deployment.router = absolute(context.host);
  request.held = from_stdin && !file.eof();
  if (!from_stdin) {
    deployment.folder = fs::path(path).parent_path();
    deployment.source.file = fs::absolute(path);
  }
  const std::string name = from_stdin ? "robot" : fs::path(path).stem().string();
  auto read = robot::read_robot({from_stdin ? "stdin" : path, deployment.source.text}, name,
                                context.options.system);
  fail_if_any(read.problems, "bad_robot", "deploy/robots/README.md");
  for (const base::Problem& hint : read.hints) context.out.note(hint.to_string());
  request.robot = std::move(read.robot);
  need_host(request.robot, deployment.host);
  deployment.name = request.robot.name;
  if (request.robot.system != 0) deployment.name += fmt::format("-{}", request.robot.system);
  if (!deployment.host.empty()) deployment.name += "-" + deployment.host;
  return request;
}

// Empty if the robot has just ended, or does not answer.
json::object shown_by(const Context& context, const std::string& key) {
  try {
    return robot::robots().ask(key, {{"do", "show"}}, context.signals, context.options.timeout);
  } catch (const Failure&) {
    return {};
  }
}

// The name of a running robot at the same router that has one of these components, and which.
struct Running {
  std::string key;
  std::string file;
  std::string component;
};
std::optional<Running> running_with(const Context& context, const UpRequest& request) {
  std::vector<std::string> wanted;
  for (const robot::Component& component : request.robot.components) {
    if (component.host != request.deployment.host) continue;
    if (auto known = robot::component_of(component.command)) wanted.push_back(std::move(*known));
  }
  for (const std::string& key : robot::robots().running()) {
    const json::object shown = shown_by(context, key);
    if (text_at(shown, "router") != request.deployment.router) continue;
    for (const json::object& item : objects(items_of(shown)))
      if (std::ranges::find(wanted, text_at(item, "component")) != wanted.end())
        return Running{key, text_at(shown, "file"), text_at(item, "component")};
  }
  return std::nullopt;
}

// A copy of the file of a running robot, under another name, would start its components again.
void refuse_copy(const Context& context, const UpRequest& request) {
  const auto running = running_with(context, request);
  const std::string own = robot::key_of(request.deployment.name, request.deployment.router);
  if (!running || running->key == own) return;  // the same name is refused by Supervisor
  throw Failure(Exit::kDenied, "robot_runs",
                fmt::format("robot {}{} already runs {} at {}", name_of(running->key),
                            running->file.empty() ? "" : fmt::format(" ({})", running->file),
                            running->component, request.deployment.router),
                fmt::format("`timsctl down {}` stops it; --system NUMBER starts a second robot",
                            name_of(running->key)));
}

Exit run_robot(Context& context, const UpRequest& request, const std::function<void()>& ready) {
  robot::Supervisor supervisor(context, request.robot, request.deployment);
  supervisor.start();
  ready();
  supervisor.serve(context.run_end(), request.held ? STDIN_FILENO : -1);
  return supervisor.failures() == 0 ? Exit::kDone : Exit::kNo;
}

void show_saved(Context& context, const std::string& name, const json::object& answer) {
  const json::array& changes = answer.at("changes").as_array();
  const std::string file = text_at(answer, "file");
  if (context.out.json()) return context.out.write(answer);
  for (const json::object& change : objects(changes)) {
    const std::string before = text_at(change, "before");
    context.out.write(fmt::format("{} = {}{}\n", text_at(change, "name"), text_at(change, "after"),
                                  before.empty() ? "" : fmt::format(" (was {})", before)));
  }
  if (changes.empty()) {
    context.out.note(fmt::format("{}: no parameters differ from {}", name, file));
  } else {
    context.out.note(fmt::format("{}: {} to {}", name,
                                 context.options.dry_run ? "would be written" : "written", file));
  }
}

Exit up(Context& context) {
  const UpRequest request = read_robot_file(context);
  const std::string& name = request.deployment.name;
  refuse_copy(context, request);
  return run_service(
      context, robot::log_file(robot::key_of(name, request.deployment.router)),
      fmt::format("robot {} is up: `timsctl component list`", name),
      [&](const std::function<void()>& ready) { return run_robot(context, request, ready); });
}

Exit down(Context& context) {
  const auto& arguments = context.options.arguments;
  const std::string key =
      robot::chosen(arguments.empty() ? "" : arguments.front(), absolute(context.host));
  const std::string name(name_of(key));
  const auto timeout = std::max(context.options.timeout, kServiceAnswers);
  (void)robot::robots().ask(key, {{"do", "down"}}, context.signals, timeout);
  if (context.out.json())
    context.out.write(
        json::object{{"schema", "tims/robot_done/1"}, {"name", name}, {"done", true}});
  context.out.note(fmt::format("robot {} is down", name));
  return Exit::kDone;
}

// timsctl component param save
Exit save(Context& context) {
  const auto& arguments = context.options.arguments;
  const auto connection = context.connect();
  const tims::Address component = need_address(arguments[0], connection->widths());
  const std::string name = component.to_string(connection->widths());
  const std::string router = absolute(context.host);
  json::object question{{"do", "save"},
                        {"address", component.to_hex()},
                        {"name", arguments.size() > 1 ? arguments[1] : std::string()},
                        {"dry_run", context.options.dry_run}};
  for (const std::string& key : robot::robots().running()) {
    const auto ask = [&](const json::object& what) {
      return robot::robots().ask(key, what, context.signals, context.options.timeout);
    };
    const json::object shown = ask({{"do", "show"}});
    const auto is_it = [&](const json::value& item) {
      return text_at(item.as_object(), "address") == component.to_hex();
    };
    if (text_at(shown, "router") != router || std::ranges::none_of(items_of(shown), is_it))
      continue;
    json::object answer = ask(question);
    answer["address"] = address_json(component, connection->widths());
    show_saved(context, name, answer);
    return Exit::kDone;
  }
  throw Failure(
      Exit::kNoSuch, "no_robot_file",
      fmt::format("no robot started by `timsctl up` on this host at {} has {}", router, name),
      "run this on the host of the robot, with the same -H as `timsctl up`");
}

Exit robot_show(Context& context) {
  constexpr Column kColumns[] = {{"ROBOT", "robot"},
                                 {"PROGRAM", "name"},
                                 {"STATUS", "status"},
                                 {"PID", "pid"},
                                 {"ROUTER", "router"}};
  json::array items;
  for (const std::string& key : robot::robots().running()) {
    json::object answer =
        robot::robots().ask(key, {{"do", "show"}}, context.signals, context.options.timeout);
    for (json::value& item : item_array(answer)) {
      item.as_object()["robot"] = name_of(key);
      item.as_object()["router"] = text_at(answer, "router");
      items.push_back(std::move(item));
    }
  }
  return show_list(context, "tims/robots/1", std::move(items), kColumns);
}

std::vector<std::string> candidates(std::string_view verb, std::size_t argument) {
  std::vector<std::string> names;
  if (verb != "down" || argument > 0) return names;
  for (const std::string& key : robot::robots().running()) names.emplace_back(name_of(key));
  return names;
}

}  // namespace
}  // namespace timsctl

int main(int argc, char** argv) {
  using namespace timsctl;
  static constexpr VerbRun kRuns[] = {
      {"up", up}, {"down", down}, {"show", robot_show}, {"save", save}};
  const VerbProgram program{"timsctl-robot", "start, supervise and stop the components of a robot.",
                            kRuns, candidates};
  return run_program(argc, argv, program);
}
