#include "tools/configuration/effects.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <functional>
#include <map>
#include <vector>

#include <unistd.h>

#include "os/clock.h"
#include "os/environment.h"
#include "os/file.h"
#include "tools/cli/admin_client.h"
#include "tools/cli/control.h"

namespace timsctl::configuration {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr tims::Duration kRouterAnswers = 2s;
constexpr tims::Duration kRouterRestarts = 20s;
constexpr tims::Duration kPause = 100ms;
constexpr tims::Duration kRobotReloads = 20s;
constexpr tims::Duration kRobotShows = 1s;  // also robots of others are asked, which may hang

tims::config::Host this_host() {
  return {.name = tims::os::host_name(), .uid = ::getuid(), .environment = tims::os::environment()};
}

// Folders of running robots: those of this user, and those of services (deploy/systemd).
std::vector<Services> all_robots() {
  std::vector<std::string> folders;
  if (const std::string own = tims::os::environment("XDG_RUNTIME_DIR"); !own.empty())
    folders.push_back(own + "/tims-robots");
  folders.emplace_back("/run/tims-robots");
  folders.push_back("/tmp/tims-robots-" + std::to_string(::geteuid()));
  std::error_code error;
  for (const auto& entry : fs::directory_iterator("/run", error))
    if (entry.path().filename().string().starts_with("tims-robot-"))
      folders.push_back(entry.path().string() + "/tims-robots");
  std::vector<Services> all;
  all.reserve(folders.size());
  for (const std::string& folder : folders)
    all.emplace_back("robot", folder,
                     Services::Hints{.none = {}, .not_running = {}, .several = {}});
  return all;
}

using Ask = std::function<json::object(const json::object& question)>;

// Calls the function for each running robot of this file, with the way to ask its supervisor.
void for_robots_of(const std::string& path, const Signals& signals,
                   const std::function<void(const Ask&)>& each) {
  for (const Services& services : all_robots())
    for (const std::string& key : services.running()) {
      const Ask ask = [&](const json::object& question) {
        const bool shows = text_at(question, "do") == "show";
        return services.ask(key, question, signals, shows ? kRobotShows : kRobotReloads);
      };
      try {
        std::error_code error;
        const std::string file = text_at(ask({{"do", "show"}}), "file");
        if (!file.empty() && fs::weakly_canonical(file, error) == fs::weakly_canonical(path, error))
          each(ask);
      } catch (const Failure&) {
        // It has just ended.
      }
    }
}

json::object item(std::string_view what, std::string_view file, std::string_view does, bool ok,
                  std::string_view text = {}) {
  return {{"what", what}, {"file", file}, {"does", does}, {"ok", ok}, {"text", text}};
}

}  // namespace

tims::config::Loaded load_router(const Texts& files) {
  tims::config::Sources sources{.files = {}, .settings = {}, .host = this_host()};
  const auto add = [&](const auto& file) {
    sources.files.push_back({.name = file.first, .text = file.second});
  };
  if (const auto main = files.find("router.toml"); main != files.end()) add(*main);
  for (const auto& file : files)
    if (file.first.starts_with("router.d/")) add(file);
  return tims::config::load(sources);
}

json::array Effects::apply(const Texts& before, const Texts& after) const {
  json::array done;
  apply_to_router(before, after, done);
  for (const auto& [file, text] : after) {
    const auto old = before.find(file);
    if (is_robot_file(file) && (old == before.end() || old->second != text))
      apply_to_robot(file, done);
  }
  for (const auto& [file, text] : before)
    if (is_robot_file(file) && !after.contains(file) && is_running(file))
      done.push_back(item(file, file, "none", true, "runs on until `timsctl down`"));
  return done;
}

json::object Effects::status() const {
  const auto connection = connect(router_, {}, kRouterAnswers);
  return AdminClient(*connection, signals_, kRouterAnswers).ask({{"ask", "status"}});
}

namespace {

void signal_router(const json::object& status, int number) {
  if (::kill(static_cast<pid_t>(number_or_zero(status, "pid")), number) != 0)
    throw Failure(Exit::kDenied, "denied", tims::os::system_error("the router").detail(),
                  "run the agent as the user of the router");
}

}  // namespace

// The service manager starts it again, with the links of the former one if it keeps them.
void Effects::restart_router() const {
  const json::object before = status();
  signal_router(before, SIGUSR2);
  const tims::Time deadline = tims::os::now() + kRouterRestarts;
  while (tims::os::now() < deadline) {
    signals_.sleep_until(tims::os::now() + kPause);
    try {
      if (number_or_zero(status(), "pid") != number_or_zero(before, "pid")) return;
    } catch (const Failure&) {
      // Not yet.
    }
  }
  throw Failure(Exit::kTimeout, "no_router", "the router has not started again",
                "its service needs Restart=always");
}

void Effects::apply_to_router(const Texts& before, const Texts& after, json::array& done) const {
  const auto changes = tims::config::changes(load_router(before).config, load_router(after).config);
  if (changes.empty()) return;
  const bool reloads = std::ranges::all_of(changes, &tims::config::Change::reloadable);
  const std::string_view does = reloads ? "reload" : "restart";
  try {
    if (reloads)
      signal_router(status(), SIGHUP);
    else
      restart_router();
    done.push_back(item("router", "router.toml", does, true));
  } catch (const Failure& failure) {
    done.push_back(item("router", "router.toml", does, false, failure.message));
  }
}

void Effects::apply_to_robot(const std::string& file, json::array& done) const {
  bool found = false;
  for_robots_of(folder_.path_of(file), signals_, [&](const Ask& ask) {
    found = true;
    try {
      const json::object answer = ask({{"do", "reload"}});
      for (const json::object& each : objects(items_of(answer)))
        done.push_back(item(text_at(each, "name"), file, text_at(each, "does"), true));
    } catch (const Failure& failure) {
      done.push_back(item(file, file, "restart", false, failure.message));
    }
  });
  if (!found) done.push_back(item(file, file, "none", true, "not running"));
}

namespace {

// Bytes that each router of the fleet has sent over each of its links, by their names, and when.
struct Counted {
  tims::Time at{};
  double bytes = 0;
  std::array<double, tims::core::kClasses> by_class{};  // 0: its router is of an earlier version
};
using Counts = std::map<std::pair<std::string, std::string>, Counted>;

Counted count_of(const json::object& link) {
  Counted made{.at = tims::os::now(), .bytes = number_or_zero(link, "wire_bytes_out")};
  const auto classes = items_of(link, "class_bytes_out");
  for (std::size_t i = 0; i < std::min(classes.size(), made.by_class.size()); ++i)
    made.by_class.at(i) = classes[i].is_number() ? classes[i].to_number<double>() : 0;
  return made;
}

Counts count_links(const AdminClient& admin, const json::object& routers) {
  Counts counts;
  for (const json::object& router : objects(items_of(routers))) {
    if (text_at(router, "state") != "up") continue;
    const bool is_own = text_at(router, "kind") == "self";
    try {
      const json::object answer =
          admin.at(is_own ? std::nullopt : router_address(router)).ask({{"ask", "links"}});
      for (const json::object& link : objects(items_of(answer)))
        if (text_at(link, "state") == "up")
          counts[{text_at(router, "name"), text_at(link, "name")}] = count_of(link);
    } catch (const Failure&) {
      // Its links stay unmeasured.
    }
  }
  return counts;
}

}  // namespace

void Effects::measure(std::vector<LinkBudget>& links) const {
  constexpr tims::Duration kMeasured = 1s;
  const auto connection = connect(router_, {}, kRouterAnswers);
  const AdminClient admin(*connection, signals_, kRouterAnswers);
  const json::object routers = walk_fleet(admin);
  const Counts before = count_links(admin, routers);
  signals_.sleep_until(tims::os::now() + kMeasured);
  Counts after = count_links(admin, routers);
  for (LinkBudget& link : links) {
    const auto first = before.find({link.host, link.other});
    const auto last = after.find({link.host, link.other});
    if (first == before.end() || last == after.end()) continue;
    const double time = base::seconds(last->second.at - first->second.at);
    const double bytes = last->second.bytes - first->second.bytes;
    if (time <= 0 || bytes < 0) continue;  // another session
    link.measured = bytes / time;
    for (std::size_t i = 0; i < link.measured_by_class.size(); ++i)
      link.measured_by_class.at(i) =
          (last->second.by_class.at(i) - first->second.by_class.at(i)) / time;
  }
}

bool Effects::is_running(const std::string& file) const {
  bool found = false;
  for_robots_of(folder_.path_of(file), signals_, [&](const Ask&) { found = true; });
  return found;
}

}  // namespace timsctl::configuration
