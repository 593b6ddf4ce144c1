#include <fmt/core.h>

#include "router/config/load.h"
#include "router/config/options.h"

namespace tims::config {

std::string print_config(const Config& config, const Origins& origins) {
  std::string out;
  std::string_view table;
  for (const Option& option : options()) {
    if (option.table() != table) {
      table = option.table();
      out += fmt::format("{}[{}]\n", out.empty() ? "" : "\n", table);
    }
    const auto origin = origins.find(option.key);
    const std::string value = fmt::format("{} = {}", option.name(), to_toml(option.get(config)));
    const Origin from = origin == origins.end() ? Origin{} : origin->second;
    out += fmt::format("{:<36}# {}\n", value, from.to_string());
  }
  return out;
}

}  // namespace tims::config
