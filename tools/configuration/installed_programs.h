// The programs of components on this host, and what they state about themselves. Anybody may ask
// the agent, so only programs of RACK are ever started: those beside timsctl that name its library.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "tools/cli/output.h"
#include "tools/configuration/description.h"

namespace timsctl::configuration {

class InstalledPrograms {
 public:
  // As by --describe; null: it is no program of RACK on this host. Valid until the next call.
  const json::object* describe(const std::string& name);
  // The same, read.
  const Description* find(const std::string& name);
  // conf_programs: all of them. Describing takes a moment each: those that are not known after a
  // second are left for the next question, and `complete` is false.
  json::object list();

 private:
  struct Known {
    std::filesystem::file_time_type written{};  // a newer one is asked again
    std::optional<json::object> described{};
    std::optional<Description> description{};
  };
  const Known* known(const std::string& name);
  // Whether the answer of known() is there without running the program.
  [[nodiscard]] bool is_known(const std::string& name) const;

  std::map<std::string, Known> known_;
  std::filesystem::file_time_type folder_written_{};
  std::vector<std::string> names_;  // of programs in the folder that name the library
};

}  // namespace timsctl::configuration
