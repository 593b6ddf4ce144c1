// A robot file's text to a Robot.
#include <algorithm>

#include <fmt/format.h>

#include "tools/timsctl/placeholders.h"
#include "tools/timsctl/robot/robot.h"
#include "tools/timsctl/toml_reader.h"

namespace timsctl::robot {

namespace {

using tims::config::Origin;

const std::vector<std::string> kPlaceholders = {"system"};

// A component as it is written, before the robot's system is known.
struct Written {
  Origin at;
  std::string name;
  std::string program;
  std::int64_t instance = 0;
  CommandLine command;
  std::vector<std::pair<std::string, std::string>> parameters;
  Component component;
};

std::string default_name(const Written& written) {
  const std::string& program = written.program.empty() ? written.command.front() : written.program;
  const std::string last = program.substr(program.rfind('/') + 1);
  return written.instance == 0 ? last : fmt::format("{}-{}", last, written.instance);
}

class RobotReader {
 public:
  RobotReader(const std::string& name, std::optional<std::int64_t> system) : system_(system) {
    robot_.name = name;
  }

  RobotFile read(const tims::config::File& file) {
    const tims::config::TomlTree tree = tims::config::parse_toml_tree(file);
    for (const tims::config::Problem& problem : tree.problems) reader_.add(problem);
    if (tree.problems.empty()) read(tree.root, file.name);
    return {.robot = std::move(robot_), .problems = reader_.problems()};
  }

 private:
  void read(const TomlNode& root, const std::string& file) {
    reader_.table(
        root, "a robot",
        {{"name", [&](const TomlNode& n) { name(n, robot_.name); }},
         {"system", [&](const TomlNode& n) { reader_.number(n, 0, kIdMax, robot_.system); }},
         {"restart", [&](const TomlNode& n) { restart(n, restart_); }},
         {"host",
          [&](const TomlNode& n) { reader_.named_tables(n, [&](const TomlNode& h) { host(h); }); }},
         {"component", [&](const TomlNode& n) { components_ = &n; }}});
    if (system_) robot_.system = *system_;
    if (components_ != nullptr) read_components(*components_);
    if (robot_.components.empty() && reader_.problems().empty())
      reader_.add({{.kind = Origin::Kind::kFile, .file = file, .line = 1, .column = 1},
                   "a robot needs a component: write [[component]]"});
  }

  void read_components(const TomlNode& node) {
    reader_.tables(node, [&](const TomlNode& n) { component(n); });
    if (robot_.components.size() > kComponentsMax)
      reader_.refuse(node, fmt::format("a robot has at most {} components", kComponentsMax));
  }

  void name(const TomlNode& node, std::string& out) {
    if (reader_.text(node, out) && !is_name(out))
      reader_.refuse(node, fmt::format("\"{}\" is no name: at most {} letters, digits, - and _",
                                       out, kNameMax));
  }

  void restart(const TomlNode& node, Restart& out) {
    static const std::vector<std::string> kWords{"never", "on-failure", "always"};
    std::string text;
    if (!reader_.text(node, text)) return;
    const auto word = std::ranges::find(kWords, text);
    if (word == kWords.end()) return reader_.unknown(node.at_value, "restart", text, kWords);
    out = static_cast<Restart>(word - kWords.begin());
  }

  void host(const TomlNode& node) {
    Host host{.name = node.key, .ssh = {}, .router = {}};
    reader_.table(node, fmt::format("[host.{}]", node.key),
                  {{"ssh", [&](const TomlNode& n) { reader_.text(n, host.ssh); }},
                   {"router", [&](const TomlNode& n) { reader_.text(n, host.router); }}});
    if (!is_name(host.name))
      reader_.add({node.at_key,
                   fmt::format("\"{}\" is no name of a host: at most {} letters, digits, - and _",
                               host.name, kNameMax)});
    if (host.ssh.empty() || host.ssh.front() == '-')
      reader_.add(
          {node.at_key, fmt::format("[host.{}] wants ssh = \"...\": how ssh calls it", host.name)});
    robot_.hosts.push_back(std::move(host));
  }

  void component(const TomlNode& node) {
    Written written;
    written.at = node.at_key;
    written.component.restart = restart_;
    reader_.table(
        node, "[[component]]",
        {{"program", [&](const TomlNode& n) { reader_.text(n, written.program); }},
         {"name", [&](const TomlNode& n) { name(n, written.name); }},
         {"instance", [&](const TomlNode& n) { reader_.number(n, 0, kIdMax, written.instance); }},
         {"parameters", [&](const TomlNode& n) { parameters(n, written); }},
         {"command", [&](const TomlNode& n) { command(n, written.command); }},
         {"host", [&](const TomlNode& n) { host_of(n, written.component.host); }},
         {"restart", [&](const TomlNode& n) { restart(n, written.component.restart); }}});
    const bool is_module = !written.program.empty();
    if (is_module != written.command.empty() ||
        (!is_module && (written.instance != 0 || !written.parameters.empty())))
      return reader_.add(
          {written.at, "a component has program, instance and parameters; or a command"});
    finish(written);
  }

  void parameters(const TomlNode& node, Written& written) {
    if (node.form != TomlNode::Form::kTable)
      return reader_.refuse(node, "parameters want a table such as { cmdTaskPrio = 30 }");
    for (const TomlNode& child : node.children) {
      if (child.key == "system" || child.key == "instance")
        reader_.add({child.at_key, fmt::format("{} stands outside of parameters", child.key)});
      std::string value;
      reader_.plain(child, value);
      check_placeholders(child, value);
      written.parameters.emplace_back(child.key, std::move(value));
    }
  }

  void command(const TomlNode& node, CommandLine& out) {
    std::string text;
    if (!reader_.text(node, text)) return;
    const auto words = split_command(text);
    if (!words || words->empty())
      return reader_.refuse(node,
                            words ? "an empty command" : "a quote that is opened and not closed");
    for (const std::string& word : *words) check_placeholders(node, word);
    out = *words;
  }

  void host_of(const TomlNode& node, std::string& out) {
    reader_.text(node, out);
    if (std::ranges::find(robot_.hosts, out, &Host::name) == robot_.hosts.end())
      reader_.refuse(node, fmt::format("no host {}: write [host.{}]", out, out));
  }

  void check_placeholders(const TomlNode& node, std::string_view text) {
    if (const auto bad = unknown_placeholder(text, kPlaceholders))
      reader_.unknown(node.at_value, "placeholder", *bad, kPlaceholders);
  }

  void finish(const Written& written) {
    Component component = written.component;
    component.name = written.name.empty() ? default_name(written) : written.name;
    for (const Component& other : robot_.components)
      if (other.name == component.name)
        return reader_.add(
            {written.at,
             fmt::format("a second component called {}: give one of them another instance or name",
                         component.name)});
    const Placeholders values{{"system", std::to_string(robot_.system)}};
    for (const std::string& word : written.command)
      component.command.push_back(filled_in(word, values));
    component.tells = !written.program.empty();
    if (component.tells)
      component.command = {written.program, fmt::format("--system={}", robot_.system),
                           fmt::format("--instance={}", written.instance)};
    for (const auto& [key, value] : written.parameters)
      component.command.push_back(fmt::format("--{}={}", key, filled_in(value, values)));
    robot_.components.push_back(std::move(component));
  }

  std::optional<std::int64_t> system_;
  TomlReader reader_;
  Robot robot_;
  Restart restart_ = Restart::kOnFailure;
  const TomlNode* components_ = nullptr;
};

}  // namespace

bool is_name(std::string_view text) {
  constexpr std::string_view kOthers = "-_";
  const auto fits = [&](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           kOthers.find(c) != std::string_view::npos;
  };
  return !text.empty() && text.size() <= kNameMax && text.front() != '-' &&
         std::ranges::all_of(text, fits);
}

RobotFile read_robot(const tims::config::File& file, const std::string& name,
                     std::optional<std::int64_t> system) {
  return RobotReader(name, system).read(file);
}

}  // namespace timsctl::robot
