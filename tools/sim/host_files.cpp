#include "tools/sim/host_files.h"

#include <array>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "base/toml_edit.h"
#include "os/file.h"
#include "tools/cli/failure.h"

namespace timsctl::sim {
namespace {

namespace fs = std::filesystem;

void write(const std::string& path, std::string_view text) {
  std::ofstream file(path);
  file << text;
  if (!file.flush())
    throw Failure(Exit::kDenied, "denied", fmt::format("cannot write {}", path),
                  "/run must be writable");
}

// Everything in `from` that is not there yet, except robot files.
void link_all(const fs::path& from, const fs::path& to) {
  std::error_code ignored;  // what cannot be linked, who needs it reports
  for (const auto& entry : fs::directory_iterator(from, ignored))
    if (entry.path().extension() != ".toml")
      fs::create_symlink(fs::absolute(entry.path()), to / entry.path().filename(), ignored);
}

}  // namespace

std::string with_system(const base::TextFile& robot, std::uint8_t system) {
  const std::array operation{base::TomlOperation{.kind = base::TomlOperation::Kind::kSet,
                                                 .path = {std::string("system")},
                                                 .value = {.value = std::int64_t{system}}}};
  base::TomlEdited edited = base::edited_toml(robot, operation);
  fail_if_any(edited.problems, "bad_robot", "deploy/robots/README.md");
  return std::move(edited.text);
}

void write_host_files(const PlannedHost& host, const std::string& sources) {
  std::error_code ignored;  // write() reports it
  fs::create_directories(host.files() + "/robots", ignored);
  fs::create_directories(host.agent_state(), ignored);
  write(host.config_file(), host.router_config);
  for (const std::string& robot : host.robots) {
    const fs::path source = fs::path(sources) / robot;
    const auto text = tims::os::read_file(source.string());
    if (!text)
      throw Failure(Exit::kNoSuch, "no_such_file",
                    fmt::format("{}: cannot read {}", host.name, source.string()),
                    "paths of `robots` begin at the folder of the fleet file");
    write(host.robot_file(robot), with_system({source.string(), *text}, host.system));
    const fs::path folder = fs::absolute(source).lexically_normal().parent_path();
    link_all(folder, host.files() + "/robots");
    link_all(folder.parent_path(), host.files());
  }
}

}  // namespace timsctl::sim
