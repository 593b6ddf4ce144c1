#include "tools/timsctl/sim/names.h"

#include <algorithm>

#include <fmt/format.h>

namespace timsctl::sim {

namespace {

// "{name}" from `at` on: where it begins and ends, braces included.
struct Brace {
  std::size_t begin = std::string_view::npos;
  std::size_t end = 0;
};
Brace next_brace(std::string_view text, std::size_t at) {
  const std::size_t begin = text.find('{', at);
  if (begin == std::string_view::npos) return {};
  const std::size_t end = text.find('}', begin);
  if (end == std::string_view::npos) return {};
  return {begin, end + 1};
}

}  // namespace

std::string host_name(const Robot& robot, std::string_view host) {
  return fmt::format("{}-{}", robot.name, host);
}

std::string line_name(const Robot& robot, std::string_view host) {
  return fmt::format("{}-{}", robot.name, host == robot.hosts.front() ? kBase : host);
}

std::vector<std::string> host_names_of(const Fleet& fleet) {
  std::vector<std::string> names = {std::string(kBase)};
  for (const Robot& robot : fleet.robots)
    for (const std::string& host : robot.hosts) names.push_back(host_name(robot, host));
  return names;
}

std::vector<std::string> line_names(const Fleet& fleet) {
  std::vector<std::string> names;
  for (const Robot& robot : fleet.robots)
    for (const std::string& host : robot.hosts) names.push_back(line_name(robot, host));
  return names;
}

std::vector<std::string> placeholder_names() { return {"robot", "host", "system"}; }

std::string unknown_placeholder(const CommandLine& command) {
  const auto known = placeholder_names();
  for (const std::string& word : command)
    for (Brace b = next_brace(word, 0); b.begin != std::string::npos; b = next_brace(word, b.end)) {
      std::string name = word.substr(b.begin + 1, b.end - b.begin - 2);
      if (std::ranges::find(known, name) == known.end()) return name;
    }
  return {};
}

std::string filled_in(std::string_view word, const Placeholders& values) {
  std::string out;
  std::size_t at = 0;
  for (Brace b = next_brace(word, 0); b.begin != std::string::npos; b = next_brace(word, b.end)) {
    const std::string_view name = word.substr(b.begin + 1, b.end - b.begin - 2);
    out += word.substr(at, b.begin - at);
    out += name == "robot" ? values.robot : name == "host" ? values.host : values.system;
    at = b.end;
  }
  return out.append(word.substr(at));
}

}  // namespace timsctl::sim
