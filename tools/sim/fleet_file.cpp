// Parses the text of a fleet file.
#include "tools/sim/fleet_file.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "base/toml.h"
#include "tools/robot/robot_file.h"
#include "tools/sim/plan.h"

namespace timsctl::sim {

namespace {

using Node = base::TomlNode;

// Their values are set in plan.cpp.
const std::vector<std::string> kPlaceholders = {"robot", "host", "system"};

bool is_lower_case_name(std::string_view text, std::size_t length_max, bool digits) {
  const auto fits = [&](char c) {
    return (c >= 'a' && c <= 'z') || (digits && c >= '0' && c <= '9');
  };
  return !text.empty() && text.size() <= length_max && text.front() >= 'a' && text.front() <= 'z' &&
         std::ranges::all_of(text, fits);
}

class FleetReader {
 public:
  FleetFile read(const base::TextFile& file) {
    const base::TomlTree tree = base::parse_toml(file);
    for (const base::Problem& problem : tree.problems) reader_.add(problem);
    if (!tree.problems.empty()) return finish();
    fleet_.profiles = built_in_profiles();
    end_ = {.file = file.name, .line = 1, .column = 1};
    reader_.table(tree.root, "a fleet",
                  {{"name", [&](const Node& n) { fleet_name(n); }},
                   {"base", [&](const Node& n) { programs(n, "[base]", fleet_.base); }},
                   {"robot", [&](const Node& n) { robots_ = &n; }},
                   {"host", [&](const Node& n) { hosts(n); }},
                   {"profile", [&](const Node& n) { profiles(n); }},
                   {"fault", [&](const Node& n) { faults_ = &n; }}});
    // Independent of the order in the text: robots refer to profiles, and faults refer to lines.
    if (robots_ != nullptr) reader_.tables(*robots_, [&](const Node& n) { robot(n); });
    if (fleet_.robots.empty() && reader_.problems().empty())
      reader_.add({end_, "a fleet needs at least one robot: add [[robot]]"});
    check_hosts();
    if (faults_ != nullptr) reader_.tables(*faults_, [&](const Node& n) { fault(n); });
    return finish();
  }

 private:
  FleetFile finish() { return {.fleet = std::move(fleet_), .problems = reader_.problems()}; }

  void fleet_name(const Node& node) {
    reader_.text(node, fleet_.name);
    if (!is_fleet_name(fleet_.name))
      reader_.refuse(node,
                     fmt::format("name requires at most {} small letters and digits, beginning "
                                 "with a letter: it is part of namespace names",
                                 kFleetNameMax));
  }

  void components(const Node& node, HostPrograms& out) {
    reader_.texts(node, [&](const Node& item, const std::string& text) {
      const auto command = base::split_words(text);
      if (!command || command->empty())
        return reader_.refuse(item, command ? "the command is empty" : "a quote is not closed");
      for (const std::string& argument : *command)
        if (const auto bad = base::unknown_placeholder(argument, kPlaceholders))
          return reader_.unknown(item.at_value, "placeholder", *bad, kPlaceholders);
      out.components.push_back(*command);
    });
  }

  // Each is copied under its name into the configuration of the host.
  void robot_files(const Node& node, HostPrograms& out) {
    namespace fs = std::filesystem;
    reader_.texts(node, [&](const Node& item, const std::string& text) {
      const fs::path path(text);
      if (path.extension() != ".toml" || !robot::is_name(path.stem().string()))
        return reader_.refuse(item, "robots requires files such as \"../robots/sim.toml\"");
      for (const std::string& other : out.robots)
        if (fs::path(other).filename() == path.filename())
          return reader_.refuse(item, fmt::format("two robot files of a host are named {}",
                                                  path.filename().string()));
      out.robots.push_back(text);
    });
  }

  void programs(const Node& node, std::string_view what, HostPrograms& out) {
    reader_.table(node, what,
                  {{"components", [&](const Node& n) { components(n, out); }},
                   {"robots", [&](const Node& n) { robot_files(n, out); }},
                   {"settings", [&](const Node& n) { settings(n, out); }}});
  }

  void settings(const Node& node, HostPrograms& out) {
    reader_.texts(node, [&](const Node& item, const std::string& text) {
      if (text.find('=') == std::string::npos)
        reader_.refuse(item,
                       fmt::format("settings requires key=value such as \"log.level=debug\", as "
                                   "tims-router --set does, not \"{}\"",
                                   text));
      out.settings.push_back(text);
    });
  }

  void hosts(const Node& node) {
    reader_.named_tables(node, [&](const Node& host) {
      host_places_.emplace_back(host.key, host.at_key);
      programs(host, fmt::format("[host.{}]", host.key), host_programs_[host.key]);
    });
  }

  void profiles(const Node& node) {
    reader_.named_tables(node, [&](const Node& table) {
      // A table for a built-in profile overrides single keys.
      Quality& quality = fleet_.profiles[table.key];
      if (table.key == "cut" || table.key == "heal" || table.key == "off")
        reader_.refuse(table, fmt::format("{} is reserved for changes of a line; name the profile "
                                          "otherwise",
                                          table.key));
      for (const Node& key : table.children) profile_key(key, quality);
    });
  }

  void profile_key(const Node& node, Quality& quality) {
    const std::vector<std::string> known(quality_keys().begin(), quality_keys().end());
    if (std::ranges::find(known, node.key) == known.end())
      return reader_.unknown(node.at_key, "key of a profile", node.key, known);
    std::string text;
    if (!reader_.text(node, text)) return;
    const auto set = set_key(quality, node.key, text);
    if (!set) reader_.refuse(node, fmt::format("{} {}", node.key, set.error().detail()));
  }

  struct RobotTable {
    std::int64_t count = 1;
    std::int64_t system = 0;  // of the first robot
    std::string name = "robot";
    Robot robot;
    std::map<std::string, HostPrograms, std::less<>> programs;
  };

  void robot(const Node& node) {
    RobotTable table;
    table.system = fleet_.robots.empty() ? 1 : fleet_.robots.back().system + 1;
    const Node* link = nullptr;
    const Node* cable = nullptr;
    reader_.table(
        node, "[[robot]]",
        {{"count", [&](const Node& n) { reader_.number(n, 1, kSystemMax, table.count); }},
         {"system", [&](const Node& n) { reader_.number(n, 1, kSystemMax, table.system); }},
         {"name", [&](const Node& n) { robot_name(n, table.name); }},
         {"hosts", [&](const Node& n) { host_names(n, table.robot.hosts); }},
         {"link", [&](const Node& n) { reader_.text(*(link = &n), table.robot.link); }},
         {"cable", [&](const Node& n) { reader_.text(*(cable = &n), table.robot.cable); }},
         {"components", [&](const Node& n) { own_components(n, table); }}});
    if (link != nullptr) check_profile(*link, table.robot.link);
    if (cable != nullptr) check_profile(*cable, table.robot.cable);
    if (table.robot.hosts.empty()) table.robot.hosts = {"main"};
    if (table.system + table.count - 1 > kSystemMax)
      return reader_.add({node.at_key, fmt::format("too many robots: the largest system number is "
                                                   "{}",
                                                   kSystemMax)});
    for (std::int64_t i = 0; i < table.count; ++i)
      append(node, table, static_cast<std::uint8_t>(table.system + i));
  }

  void append(const Node& node, const RobotTable& table, std::uint8_t system) {
    for (const Robot& other : fleet_.robots)
      if (other.system == system)
        return reader_.add(
            {node.at_key, fmt::format("system {} is already used by {}: systems must be "
                                      "unique",
                                      system, other.name)});
    Robot robot = table.robot;
    robot.system = system;
    robot.name = fmt::format("{}{}", table.name, system);
    for (const auto& [host, programs] : table.programs) {
      if (std::ranges::find(robot.hosts, host) == robot.hosts.end())
        return reader_.unknown(node.at_key, "host in components of [[robot]]", host, robot.hosts);
    }
    for (const std::string& host : robot.hosts) {
      HostPrograms& all = robot.programs[host];
      if (const auto general = host_programs_.find(host); general != host_programs_.end())
        all = general->second;
      if (const auto own = table.programs.find(host); own != table.programs.end())
        all.components.insert(all.components.end(), own->second.components.begin(),
                              own->second.components.end());
    }
    fleet_.robots.push_back(std::move(robot));
  }

  void robot_name(const Node& node, std::string& out) {
    reader_.text(node, out);
    if (!is_lower_case_name(out, kRobotNameMax, false) || out == "base")
      reader_.refuse(node, fmt::format("a robot name has at most {} small letters, no "
                                       "digits, and is not base",
                                       kRobotNameMax));
  }

  void host_names(const Node& node, std::vector<std::string>& out) {
    constexpr std::string_view kTaken[] = {"base", "lo", "all", "default"};
    reader_.texts(node, [&](const Node& item, const std::string& text) {
      if (!is_lower_case_name(text, kHostNameMax, true) ||
          std::ranges::find(kTaken, text) != std::end(kTaken))
        reader_.refuse(item, fmt::format("a host name has at most {} small letters and digits, "
                                         "begins with a letter, and is none of {}",
                                         kHostNameMax, fmt::join(kTaken, ", ")));
      if (std::ranges::find(out, text) != out.end())
        reader_.refuse(item, fmt::format("duplicate host \"{}\"", text));
      out.push_back(text);
    });
    if (out.size() > kHostsMax)
      reader_.refuse(node, fmt::format("a robot has at most {} hosts", kHostsMax));
  }

  void own_components(const Node& node, RobotTable& table) {
    if (node.form != Node::Form::kTable)
      return reader_.refuse(node,
                            "components of a robot require a host: "
                            "components.main = [\"...\"]");
    for (const Node& host : node.children) components(host, table.programs[host.key]);
  }

  void check_profile(const Node& node, const std::string& name) {
    if (fleet_.profiles.contains(name)) return;
    std::vector<std::string> known;
    for (const auto& [profile, quality] : fleet_.profiles) known.push_back(profile);
    reader_.unknown(node.at_value, "profile", name, known);
  }

  // [host.X] must refer to a host of a robot.
  void check_hosts() {
    std::vector<std::string> all;
    for (const Robot& robot : fleet_.robots)
      for (const std::string& host : robot.hosts)
        if (std::ranges::find(all, host) == all.end()) all.push_back(host);
    for (const auto& [name, at] : host_places_)
      if (std::ranges::find(all, name) == all.end()) reader_.unknown(at, "host", name, all);
  }

  void fault(const Node& node) {
    Step step;
    tims::Duration length{};
    tims::Duration every{};
    std::string what;
    std::string direction;
    const Node* place = nullptr;
    const Node* action = nullptr;
    reader_.table(node, "[[fault]]",
                  {{"at", [&](const Node& n) { reader_.duration(n, true, step.at); }},
                   {"line", [&](const Node& n) { reader_.text(*(place = &n), step.line); }},
                   {"host", [&](const Node& n) { reader_.text(*(place = &n), step.host); }},
                   {"do", [&](const Node& n) { reader_.text(*(action = &n), what); }},
                   {"direction", [&](const Node& n) { reader_.text(n, direction); }},
                   {"for", [&](const Node& n) { reader_.duration(n, false, length); }},
                   {"every", [&](const Node& n) { reader_.duration(n, false, every); }}});
    if (length > tims::Duration{}) step.duration = length;
    if (every > tims::Duration{}) step.every = every;
    step.arguments = base::split_words(what).value_or(tims::os::Command{});
    if (!direction.empty()) step.arguments.push_back("direction=" + direction);
    if (place == nullptr || action == nullptr || step.line.empty() == step.host.empty())
      return reader_.add({node.at_key, "a fault requires at, do, and either line or host"});
    if (every > tims::Duration{} && every <= length)
      reader_.add(
          {node.at_key, "every must be longer than for: a fault is undone before it is repeated"});
    step.line.empty() ? check_host_step(*place, *action, step)
                      : check_line_step(*place, *action, step);
    fleet_.steps.push_back(std::move(step));
  }

  void check_line_step(const Node& place, const Node& action, const Step& step) {
    const auto lines = line_names(fleet_);
    if (std::ranges::find(lines, step.line) == lines.end())
      return reader_.unknown(place.at_value, "line", step.line, lines);
    const auto state = changed({}, {}, step.arguments, fleet_.profiles);
    if (!state) reader_.refuse(action, fmt::format("do: {}", state.error().detail()));
  }

  void check_host_step(const Node& place, const Node& action, const Step& step) {
    const auto hosts = host_names_of(fleet_);
    if (std::ranges::find(hosts, step.host) == hosts.end())
      return reader_.unknown(place.at_value, "host", step.host, hosts);
    if (step.arguments != tims::os::Command{"kill"} && step.arguments != tims::os::Command{"start"})
      reader_.refuse(action, "do requires kill or start for a host");
  }

  base::TomlReader reader_;
  Fleet fleet_;
  base::Place end_;
  const Node* robots_ = nullptr;
  const Node* faults_ = nullptr;
  std::map<std::string, HostPrograms, std::less<>> host_programs_;
  std::vector<std::pair<std::string, base::Place>> host_places_;
};

}  // namespace

bool is_fleet_name(std::string_view name) { return is_lower_case_name(name, kFleetNameMax, true); }

FleetFile read_fleet(const base::TextFile& file) { return FleetReader().read(file); }

}  // namespace timsctl::sim
