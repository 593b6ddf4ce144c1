#include "tools/deploy/order.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "os/file.h"
#include "router/config/load.h"
#include "tools/deploy/answers.h"
#include "tools/robot/robot_file.h"

namespace timsctl::deploy {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kRobotMax = 60'000;  // bytes, as for `timsctl up`
constexpr std::string_view kCarriedSource =
    "deb [trusted=yes] copy:/var/lib/tims-deploy/packages ./";

std::string content_of(const fs::path& path, std::size_t bytes_max) {
  auto text = tims::os::read_file(path, bytes_max);
  if (!text)
    throw Failure(Exit::kNoSuch, "no_such_file", text.error().detail(),
                  "paths in a robot file start at its folder");
  return std::move(*text);
}

// Plain files of a folder and of the folders that may be in it. Anything else would be left out
// without a word, so it is refused; hidden files and the authority of a fleet belong to their
// owner.
void read_folder(const fs::path& folder, Target& target) {
  if (!fs::is_directory(folder))
    throw Failure(Exit::kNoSuch, "no_such_file",
                  fmt::format("{}: no folder {}", target.name, folder.string()),
                  "files names a folder with router.toml, router.d, robots or keys");
  for (auto entry = fs::recursive_directory_iterator(folder);
       entry != fs::recursive_directory_iterator(); ++entry) {
    const std::string name = entry->path().lexically_relative(folder);
    if (entry->path().filename().string().starts_with('.') || name == "keys/authority") {
      entry.disable_recursion_pending();
      continue;
    }
    if (entry->is_directory()) continue;
    if (!entry->is_regular_file() || !is_deployed_name(name))
      throw Failure(Exit::kNo, "bad_file",
                    fmt::format("{}: {} is not deployed", target.name, entry->path().string()),
                    "a host gets router.toml, and plain files in router.d, robots and keys");
    target.files[name] = content_of(entry->path(), kFileMax);
    if (target.files.size() > kFilesMax)
      throw Failure(Exit::kNo, "bad_file",
                    fmt::format("{}: more than {} files", folder.string(), kFilesMax));
  }
}

// As the router of that host reads it.
void check_router(const Target& target) {
  tims::config::Sources sources{
      .files = {}, .settings = {}, .host = {.name = target.name, .environment = {}}};
  for (const auto& [name, text] : target.files)
    if (name == "router.toml") sources.files.push_back({name, text});
  for (const auto& [name, text] : target.files)
    if (name.starts_with("router.d/")) sources.files.push_back({name, text});
  const auto loaded = tims::config::load(sources);
  if (loaded.ok()) return;
  std::string text;
  for (const auto& problem : loaded.problems)
    text += fmt::format("{}{}: {}", text.empty() ? "" : "\n", target.name, problem.to_string());
  throw Failure(Exit::kNo, "bad_config", text, "nothing was changed");
}

Target target_of(const robot::Host& host, const fs::path& folder) {
  Target target{.name = host.name, .ssh = host.ssh, .packages = host.packages, .files = {}};
  if (!host.files.empty()) read_folder(folder / host.files, target);
  return target;
}

// A folder beside the robot file is carried along; anything else is for apt, in one of its forms.
void read_repository(const std::string& repository, const fs::path& folder, Order& order) {
  if (repository.empty()) return;
  if (repository.starts_with("deb ") || repository.starts_with("Types:")) {
    order.source = repository;
    return;
  }
  order.folder = folder / repository;
  order.source = kCarriedSource;
  order.packages = packages_in(content_of(fs::path(order.folder) / "Packages", kAnswerMax));
  if (order.packages.empty())
    throw Failure(Exit::kNo, "bad_repository", order.folder + "/Packages lists no package",
                  "`tools/dev packages --repo DIR` makes such a folder");
}

void choose(const std::string& name, Order& order) {
  if (name.empty()) return;
  std::vector<std::string> names(order.targets.size());
  std::ranges::transform(order.targets, names.begin(), &Target::name);
  std::erase_if(order.targets, [&](const Target& target) { return target.name != name; });
  if (!order.targets.empty()) return;
  const std::vector<std::string_view> known(names.begin(), names.end());
  throw usage_error(fmt::format("--on: no host \"{}\" is deployed", name),
                    nearest_hint(name, known));
}

}  // namespace

Order read_order(const Context& context) {
  const fs::path path = context.options.arguments.front();
  const std::string text = content_of(path, kRobotMax);
  const auto read = robot::read_robot({path, text}, path.stem(), context.options.system);
  fail_if_any(read.problems, "bad_robot", "deploy/robots/README.md");
  const robot::Robot& robot = read.robot;
  const fs::path folder = path.parent_path();
  Order order{.robot = robot.name, .targets = {}, .source = {}, .folder = {}, .packages = {}};
  if (!robot.deploy.host.ssh.empty()) {
    order.targets.push_back(target_of(robot.deploy.host, folder));
    order.targets.back().files[fmt::format("robots/{}.toml", robot.name)] = text;
  }
  for (const robot::Host& host : robot.hosts) order.targets.push_back(target_of(host, folder));
  if (order.targets.empty())
    throw Failure(Exit::kNoSuch, "no_host",
                  fmt::format("{} names no other computer", path.string()),
                  "[deploy] with ssh = \"user@host\" names the one that runs it");
  choose(context.options.on, order);
  read_repository(robot.deploy.repository, folder, order);
  for (const Target& target : order.targets) check_router(target);
  return order;
}

}  // namespace timsctl::deploy
