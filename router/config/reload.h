// What a new configuration changes, and what of it can be had without a restart.
#pragma once

#include <string>
#include <vector>

#include "router/config/config.h"

namespace tims::config {

struct Change {
  std::string key;     // "log.level"
  std::string before;  // as TOML: "\"info\""
  std::string after;
  bool reloadable = false;

  // "log.level: \"info\" -> \"debug\"", with ", needs a restart" behind it where that is so.
  [[nodiscard]] std::string to_string() const;
};

// In the order of the option table; empty when nothing changed.
std::vector<Change> changes(const Config& before, const Config& after);

// `running` with the reloadable values of `wanted`: what a router without restart may go on with.
Config reloaded(const Config& running, const Config& wanted);

}  // namespace tims::config
