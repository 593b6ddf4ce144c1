#include <fmt/core.h>

#include "router/config/load.h"
#include "router/config/options.h"

namespace tims::config {

namespace {

// A line of TOML, with a comment that says where it comes from.
std::string with_origin(std::string_view line, const Origins& origins, std::string_view key) {
  const auto found = origins.find(key);
  const Origin origin = found == origins.end() ? Origin{} : found->second;
  return fmt::format("{:<36}# {}\n", line, origin.to_string());
}

}  // namespace

std::string print_config(const Config& config, const Origins& origins) {
  std::string out;
  std::string opened;
  for (const Entry& entry : entries(config)) {
    const std::string table = entry.key.substr(0, entry.key.rfind('.'));
    if (table != opened) {
      opened = table;
      const bool is_item = find_list(entry.option->table()) != nullptr;
      out += out.empty() ? "" : "\n";
      out += is_item ? with_origin(fmt::format("[[{}]]", entry.option->table()), origins, table)
                     : fmt::format("[{}]\n", table);
    }
    out += with_origin(fmt::format("{} = {}", entry.option->name(), to_toml(entry.get(config))),
                       origins, entry.key);
  }
  return out;
}

}  // namespace tims::config
