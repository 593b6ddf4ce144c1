// timsctl config check and migrate: configuration files of this host, without a router.
#include <filesystem>

#include <fmt/format.h>
#include <unistd.h>

#include "base/renamed_keys.h"
#include "os/environment.h"
#include "os/file.h"
#include "os/replace_file.h"
#include "router/config/config.h"
#include "router/config/load.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/configuration/differences.h"
#include "tools/robot/robot_file.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/config_edit.h"

namespace timsctl {
namespace {

// What is wrong in a file, and what is dangerous or should be written in another way.
struct Checked {
  std::vector<base::Problem> problems;
  std::vector<std::string> cautions;
};

tims::config::Host this_host() {
  return {.name = tims::os::host_name(), .uid = ::getuid(), .environment = tims::os::environment()};
}

[[noreturn]] void throw_unreadable(const std::string& path, const tims::Error& error) {
  const bool is_there = std::filesystem::exists(path);
  throw Failure(is_there ? Exit::kDenied : Exit::kNoSuch, is_there ? "denied" : "no_such_file",
                error.message());
}

Checked check_router(const std::string& path) {
  auto files = tims::config::read_files(path);
  if (!files) throw_unreadable(path, files.error());
  const auto loaded =
      tims::config::load({.files = std::move(*files), .settings = {}, .host = this_host()});
  Checked checked;
  for (const tims::config::Problem& problem : loaded.problems)
    checked.problems.push_back(
        {{problem.at.file, problem.at.line, problem.at.column}, problem.text});
  if (loaded.ok()) checked.cautions = tims::config::cautions(loaded.config);
  return checked;
}

Checked check_robot(const std::string& path, const std::string& text) {
  const robot::RobotFile read =
      robot::read_robot({path, text}, std::filesystem::path(path).stem().string());
  Checked checked{.problems = read.problems, .cautions = {}};
  for (const base::Problem& hint : read.hints) checked.cautions.push_back(hint.to_string());
  return checked;
}

// A robot has components; all other files are those of routers.
Checked check_file(const std::string& path) {
  const auto text = tims::os::read_file(path);
  if (!text) return check_router(path);
  const base::TomlTree tree = base::parse_toml({path, *text});
  const base::TomlPath components{std::string("component")};
  return base::find_node(tree.root, components) != nullptr ? check_robot(path, *text)
                                                           : check_router(path);
}

json::object report(const std::string& path, const Checked& checked) {
  json::array items;
  for (const base::Problem& problem : checked.problems)
    items.push_back(json::object{{"file", problem.at.file},
                                 {"line", problem.at.line},
                                 {"column", problem.at.column},
                                 {"text", problem.text}});
  return {{"schema", "tims/config_check/1"},
          {"file", path},
          {"ok", checked.problems.empty()},
          {"cautions", json::array(checked.cautions.begin(), checked.cautions.end())},
          {"items", std::move(items)}};
}

// --- migrate

struct Migration {
  std::string path;
  std::string text;
  std::string diff;  // empty: there is nothing to rewrite
};

Migration migration_of(const std::string& path) {
  const auto text = tims::os::read_file(path);
  if (!text) throw_unreadable(path, text.error());
  base::TomlEdited edited = base::migrated({path, *text});
  fail_if_any(edited.problems, "bad_file", "nothing was changed");
  std::string diff = configuration::difference(path, *text, edited.text).diff;
  return {.path = path, .text = std::move(edited.text), .diff = std::move(diff)};
}

void write(const Migration& migration) {
  if (const auto done = tims::os::replace_file(migration.path, migration.text); !done)
    throw Failure(Exit::kDenied, "cannot_write", done.error().detail(),
                  "do you have write permission?");
}

}  // namespace

Exit config_check(Context& context) {
  const std::string& path = context.options.arguments.front();
  const Checked checked = check_file(path);
  const bool ok = checked.problems.empty();
  if (context.out.json()) {
    context.out.write(report(path, checked));
    return ok ? Exit::kDone : Exit::kNo;
  }
  for (const base::Problem& problem : checked.problems)
    context.out.write(problem.to_string() + "\n");
  for (const std::string& caution : checked.cautions) context.out.write(caution + "\n");
  if (ok)
    context.out.write(path + ": no errors\n");
  else
    context.out.note(fmt::format("{}: {} error{}", path, checked.problems.size(),
                                 checked.problems.size() == 1 ? "" : "s"));
  return ok ? Exit::kDone : Exit::kNo;
}

// All files are read before one is written.
Exit config_migrate(Context& context) {
  std::vector<Migration> all;
  all.reserve(context.options.arguments.size());
  for (const std::string& path : context.options.arguments) all.push_back(migration_of(path));
  json::array items;
  for (const Migration& migration : all) {
    const bool differs = !migration.diff.empty();
    if (differs && !context.options.dry_run) write(migration);
    items.push_back(
        json::object{{"file", migration.path}, {"changed", differs}, {"diff", migration.diff}});
    if (!context.out.json() && differs)
      context.out.write(diff_in_colour(migration.diff, context.out.look().colour));
    if (!differs) context.out.note(migration.path + ": no key has a former name");
  }
  if (context.out.json())
    context.out.write(json::object{{"schema", "tims/config_migrate/1"},
                                   {"dry_run", context.options.dry_run},
                                   {"items", std::move(items)}});
  return Exit::kDone;
}

}  // namespace timsctl
