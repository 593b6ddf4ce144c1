// What a new configuration changes, and what of it can be had without a restart.
#pragma once

#include <string>
#include <vector>

#include "router/config/config.h"

namespace tims::config {

struct Change {
  std::string key;     // "log.level"; `link "10.9.1.1:2010" rate` of a list's item
  std::string before;  // as TOML: "\"info\""; empty when items came, went or moved
  std::string after;   // as TOML; else "added", "removed", "in another order"
  bool reloadable = false;

  // "log.level: \"info\" -> \"debug\"", "link \"10.9.1.1:2010\": added"; with ", needs a restart"
  // behind it where that is so.
  [[nodiscard]] std::string to_string() const;
};

// In the order of the option table; empty when nothing changed. Links and routes do without a
// restart, unless something they were checked against (router.role, udp.listen, ...) waits for one:
// then they wait with it.
std::vector<Change> changes(const Config& before, const Config& after);

// `running` with the reloadable values of `wanted`: what a router without restart may go on with.
Config reloaded(const Config& running, const Config& wanted);

}  // namespace tims::config
