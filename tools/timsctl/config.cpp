// timsctl config: what the router runs with, and what a file would make of it.
#include <filesystem>

#include <fmt/format.h>
#include <unistd.h>

#include "router/config/load.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/timsctl/verbs.h"

namespace timsctl {

namespace {

constexpr Column kWithOrigin[] = {{"KEY", "key"},
                                  {"VALUE", "value"},
                                  {"ORIGIN", "origin"},
                                  {"RELOADABLE", "reloadable", As::kText, true}};
constexpr Column kWithout[] = {{"KEY", "key"},
                               {"VALUE", "value"},
                               {"ORIGIN", "origin", As::kText, true},
                               {"RELOADABLE", "reloadable", As::kText, true}};

tims::config::Host this_host() {
  tims::config::Host host;
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) == 0) host.name = name.data();
  host.uid = ::getuid();
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view line = *entry;
    const std::size_t equals = line.find('=');
    if (equals != std::string_view::npos)
      host.environment.emplace(line.substr(0, equals), line.substr(equals + 1));
  }
  return host;
}

tims::config::Loaded load_file(const std::string& path) {
  auto files = tims::config::read_files(path);
  if (!files)
    throw Failure(std::filesystem::exists(path) ? Exit::kDenied : Exit::kNoSuch,
                  std::filesystem::exists(path) ? "denied" : "no_such_file",
                  files.error().message());
  return tims::config::load({.files = std::move(*files), .settings = {}, .host = this_host()});
}

json::object report(const std::string& path, const tims::config::Loaded& loaded) {
  json::array items;
  for (const tims::config::Problem& problem : loaded.problems)
    items.push_back(json::object{{"file", problem.at.file},
                                 {"line", problem.at.line},
                                 {"column", problem.at.column},
                                 {"text", problem.text}});
  return {{"schema", "tims/config_check/1"},
          {"file", path},
          {"ok", loaded.ok()},
          {"items", std::move(items)}};
}

}  // namespace

Exit config_show(Context& context) {
  return show_items(context, {{"ask", "config"}},
                    context.options.origin ? std::span<const Column>(kWithOrigin) : kWithout);
}

Exit config_check(Context& context) {
  const std::string& path = context.options.arguments.front();
  const tims::config::Loaded loaded = load_file(path);
  const Exit exit = loaded.ok() ? Exit::kDone : Exit::kNo;
  if (context.out.json()) {
    context.out.write(report(path, loaded));
    return exit;
  }
  for (const tims::config::Problem& problem : loaded.problems)
    context.out.write(problem.to_string() + "\n");
  if (loaded.ok())
    context.out.write(path + ": no errors\n");
  else
    context.out.note(fmt::format("{}: {} error{}", path, loaded.problems.size(),
                                 loaded.problems.size() == 1 ? "" : "s"));
  return exit;
}

}  // namespace timsctl
