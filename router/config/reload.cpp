#include "router/config/reload.h"

#include <fmt/core.h>

#include "router/config/options.h"

namespace tims::config {

std::vector<Change> changes(const Config& before, const Config& after) {
  std::vector<Change> list;
  for (const Option& option : options()) {
    const Value old_value = option.get(before);
    const Value new_value = option.get(after);
    if (old_value == new_value) continue;
    list.push_back({.key = std::string(option.key),
                    .before = to_toml(old_value),
                    .after = to_toml(new_value),
                    .reloadable = option.reload == Reload::kYes});
  }
  return list;
}

Config reloaded(const Config& running, const Config& wanted) {
  Config config = running;
  for (const Option& option : options())
    if (option.reload == Reload::kYes) option.set(config, option.get(wanted));
  return config;
}

std::string Change::to_string() const {
  return fmt::format("{}: {} -> {}{}", key, before, after, reloadable ? "" : ", needs a restart");
}

}  // namespace tims::config
