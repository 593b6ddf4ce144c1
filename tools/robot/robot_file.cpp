// Parses the text of a robot file.
#include "tools/robot/robot_file.h"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include <fmt/format.h>

#include "base/renamed_keys.h"
#include "base/toml.h"
#include "base/toml_edit.h"
#include "os/file.h"
#include "os/replace_file.h"

namespace timsctl::robot {

namespace {

using Node = base::TomlNode;

namespace fs = std::filesystem;

const std::vector<std::string> kPlaceholders = {"system"};

// Lower case letters, digits, and + - . behind the first character.
bool is_package_name(std::string_view name) {
  constexpr std::string_view kOthers = "+-.";
  const auto is_plain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); };
  return name.size() >= 2 && name.size() <= 100 && is_plain(name.front()) &&
         std::ranges::all_of(name, [&](char c) {
           return is_plain(c) || kOthers.find(c) != std::string_view::npos;
         });
}

// A component as written, before the system of the robot is known.
struct ComponentTable {
  base::Place at;
  std::string name;
  std::string program;
  std::int64_t instance = 0;
  tims::os::Command command;
  std::vector<std::pair<std::string, std::string>> parameters;
  Component component;
};

std::string default_name(const ComponentTable& written) {
  const std::string& program = written.program.empty() ? written.command.front() : written.program;
  const std::string last = program.substr(program.rfind('/') + 1);
  return written.instance == 0 ? last : fmt::format("{}-{}", last, written.instance);
}

class RobotReader {
 public:
  RobotReader(const std::string& name, std::optional<std::int64_t> system) : system_(system) {
    robot_.name = name;
  }

  RobotFile read(const base::TextFile& file) {
    base::TomlTree tree = base::parse_toml(file);
    std::vector<base::Problem> hints = base::rename_former_keys(tree);
    for (const base::Problem& problem : tree.problems) reader_.add(problem);
    if (tree.problems.empty()) read(tree.root, file.name);
    return {.robot = std::move(robot_), .problems = reader_.problems(), .hints = std::move(hints)};
  }

 private:
  void read(const Node& root, const std::string& file) {
    reader_.table(
        root, "a robot",
        {{"name", [&](const Node& n) { name(n, robot_.name); }},
         {"system", [&](const Node& n) { reader_.number(n, 0, kIdMax, robot_.system); }},
         {"files", [&](const Node& n) { files(n); }},
         {"restart", [&](const Node& n) { restart(n, restart_); }},
         {"host", [&](const Node& n) { reader_.named_tables(n, [&](const Node& h) { host(h); }); }},
         {"deploy", [&](const Node& n) { deploy(n); }},
         {"component", [&](const Node& n) { components_ = &n; }}});
    if (system_) robot_.system = *system_;
    robot_.files = base::filled_in(robot_.files,
                                   base::Placeholders{{"system", std::to_string(robot_.system)}});
    if (components_ != nullptr) read_components(*components_);
    for (Host& host : robot_.hosts) {
      if (host.packages.empty()) host.packages = robot_.deploy.host.packages;
      if (host.name == kMainHost && !robot_.deploy.host.ssh.empty())
        reader_.add({{.file = file, .line = 1, .column = 1},
                     "[deploy] is the host main: give [host.main] another name"});
    }
    if (robot_.components.empty() && reader_.problems().empty())
      reader_.add({{.file = file, .line = 1, .column = 1},
                   "a robot needs at least one component: add [[component]]"});
  }

  void read_components(const Node& node) {
    reader_.tables(node, [&](const Node& n) { component(n); });
    if (robot_.components.size() > kComponentsMax)
      reader_.refuse(node, fmt::format("a robot has at most {} components", kComponentsMax));
  }

  void name(const Node& node, std::string& out) {
    if (reader_.text(node, out) && !is_name(out))
      reader_.refuse(node, fmt::format("\"{}\" is not a name: at most {} letters, digits, - and _",
                                       out, kNameMax));
  }

  void files(const Node& node) {
    if (!reader_.text(node, robot_.files)) return;
    check_placeholders(node, robot_.files);
    if (robot_.files.empty()) reader_.refuse(node, "files requires the path of a folder");
  }

  void restart(const Node& node, Restart& out) {
    static const std::vector<std::string> kNames{"never", "on-failure", "always"};
    std::string text;
    if (!reader_.text(node, text)) return;
    const auto found = std::ranges::find(kNames, text);
    if (found == kNames.end()) return reader_.unknown(node.at_value, "restart", text, kNames);
    out = static_cast<Restart>(found - kNames.begin());
  }

  void deploy(const Node& node) {
    Deploy& deploy = robot_.deploy;
    deploy.host.name = kMainHost;
    reader_.table(node, "[deploy]",
                  {{"ssh", [&](const Node& n) { reader_.text(n, deploy.host.ssh); }},
                   {"packages", [&](const Node& n) { packages(n, deploy.host.packages); }},
                   {"files", [&](const Node& n) { reader_.text(n, deploy.host.files); }},
                   {"repository", [&](const Node& n) { repository(n, deploy.repository); }}});
    if (deploy.host.ssh.starts_with('-'))
      reader_.add({node.at_key, "[deploy]: ssh is not a destination for ssh"});
  }

  void repository(const Node& node, std::string& out) {
    if (!reader_.text(node, out)) return;
    const bool is_stanza = out.starts_with("Types:");
    if (!std::ranges::all_of(out, [&](char c) { return c >= ' ' || (is_stanza && c == '\n'); }))
      reader_.refuse(node,
                     "repository is a folder, one line of sources.list, or lines from Types: on");
  }

  void packages(const Node& node, std::vector<std::string>& out) {
    reader_.texts(node, [&](const Node& n, const std::string& name) {
      if (!is_package_name(name))
        return reader_.refuse(n, fmt::format("\"{}\" is not the name of a Debian package", name));
      out.push_back(name);
    });
  }

  void host(const Node& node) {
    Host host{.name = node.key, .ssh = {}, .router = {}};
    reader_.table(node, fmt::format("[host.{}]", node.key),
                  {{"ssh", [&](const Node& n) { reader_.text(n, host.ssh); }},
                   {"router", [&](const Node& n) { reader_.text(n, host.router); }},
                   {"packages", [&](const Node& n) { packages(n, host.packages); }},
                   {"files", [&](const Node& n) { reader_.text(n, host.files); }}});
    if (!is_name(host.name))
      reader_.add({node.at_key,
                   fmt::format("\"{}\" is not a host name: at most {} letters, digits, - and _",
                               host.name, kNameMax)});
    if (host.ssh.empty() || host.ssh.front() == '-')
      reader_.add(
          {node.at_key,
           fmt::format("[host.{}] requires ssh = \"...\", the destination for ssh", host.name)});
    robot_.hosts.push_back(std::move(host));
  }

  void component(const Node& node) {
    ComponentTable written;
    written.at = node.at_key;
    written.component.restart = restart_;
    reader_.table(
        node, "[[component]]",
        {{"program", [&](const Node& n) { reader_.text(n, written.program); }},
         {"name", [&](const Node& n) { name(n, written.name); }},
         {"instance", [&](const Node& n) { reader_.number(n, 0, kIdMax, written.instance); }},
         {"parameters", [&](const Node& n) { parameters(n, written); }},
         {"command", [&](const Node& n) { command(n, written.command); }},
         {"host", [&](const Node& n) { host_of(n, written.component.host); }},
         {"restart", [&](const Node& n) { restart(n, written.component.restart); }}});
    const bool is_module = !written.program.empty();
    if (is_module != written.command.empty() ||
        (!is_module && (written.instance != 0 || !written.parameters.empty())))
      return reader_.add(
          {written.at, "a component requires program, instance and parameters, or a command"});
    finish(written);
  }

  void parameters(const Node& node, ComponentTable& written) {
    if (node.form != Node::Form::kTable)
      return reader_.refuse(node, "parameters requires a table such as { cmdTaskPrio = 30 }");
    for (const Node& child : node.children) {
      if (child.key == "system" || child.key == "instance")
        reader_.add({child.at_key, fmt::format("{} must be outside of parameters", child.key)});
      std::string value;
      reader_.plain(child, value);
      check_placeholders(child, value);
      written.parameters.emplace_back(child.key, std::move(value));
    }
  }

  void command(const Node& node, tims::os::Command& out) {
    std::string text;
    if (!reader_.text(node, text)) return;
    const auto arguments = base::split_words(text);
    if (!arguments || arguments->empty())
      return reader_.refuse(node, arguments ? "the command is empty" : "a quote is not closed");
    for (const std::string& token : *arguments) check_placeholders(node, token);
    out = *arguments;
  }

  void host_of(const Node& node, std::string& out) {
    reader_.text(node, out);
    if (std::ranges::find(robot_.hosts, out, &Host::name) == robot_.hosts.end())
      reader_.refuse(node, fmt::format("unknown host {}: add [host.{}]", out, out));
  }

  void check_placeholders(const Node& node, std::string_view text) {
    if (const auto bad = base::unknown_placeholder(text, kPlaceholders))
      reader_.unknown(node.at_value, "placeholder", *bad, kPlaceholders);
  }

  void finish(const ComponentTable& written) {
    Component component = written.component;
    component.name = written.name.empty() ? default_name(written) : written.name;
    for (const Component& other : robot_.components)
      if (other.name == component.name)
        return reader_.add(
            {written.at,
             fmt::format("duplicate component {}: give one of them another instance or name",
                         component.name)});
    const base::Placeholders values{{"system", std::to_string(robot_.system)}};
    for (const std::string& token : written.command)
      component.command.push_back(base::filled_in(token, values));
    component.notifies = !written.program.empty();
    if (component.notifies)
      component.command = {written.program, fmt::format("--system={}", robot_.system),
                           fmt::format("--instance={}", written.instance)};
    for (const auto& [key, value] : written.parameters)
      component.command.push_back(fmt::format("--{}={}", key, base::filled_in(value, values)));
    robot_.components.push_back(std::move(component));
  }

  std::optional<std::int64_t> system_;
  base::TomlReader reader_;
  Robot robot_;
  Restart restart_ = Restart::kOnFailure;
  const Node* components_ = nullptr;
};

// A number stays one, unless TOML would write it in another form.
base::TomlInput input_of(const std::string& value) {
  const auto whole = base::parse_number<std::int64_t>(value);
  const auto real = base::parse_number<double>(value);
  base::TomlInput input{.value = value};
  if (whole)
    input.value = *whole;
  else if (real)
    input.value = *real;
  return input.to_toml() == value ? input : base::TomlInput{.value = value};
}

// Sets a parameter of a component in a text.
base::TomlEdited with_parameter(const base::TextFile& file, std::size_t component,
                                const std::string& name, const std::string& value) {
  const base::TomlPath path{"component", component, "parameters", name};
  base::TomlTree tree = base::parse_toml(file);
  std::vector<base::TomlOperation> operations;
  for (const base::FormerKey& former : base::former_keys(tree))
    if (former.path_now() == path) operations.push_back(former.renaming());
  (void)base::rename_former_keys(tree);
  const Node* old = base::find_node(tree.root, path);
  const bool was_text = old != nullptr && std::holds_alternative<std::string>(old->value);
  operations.push_back(
      {.path = path, .value = was_text ? base::TomlInput{.value = value} : input_of(value)});
  return base::edited_toml(file, operations);
}

std::string* argument(Component& component, const std::string& name) {
  const std::string begin = "--" + name + "=";
  const auto found = std::ranges::find_if(
      component.command, [&](const std::string& given) { return given.starts_with(begin); });
  return found == component.command.end() ? nullptr : &*found;
}

tims::Error refused(std::string text) { return {tims::Errc::kInvalidArgument, std::move(text)}; }

// Keeps the owner and the mode, if that is permitted.
void replace_file(const std::string& path, std::string_view text) {
  if (const auto done = tims::os::replace_file(path, text); !done)
    throw Failure(Exit::kDenied, "cannot_write", done.error().detail(),
                  "do you have write permission?");
}

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

RobotFile read_robot(const base::TextFile& file, const std::string& name,
                     std::optional<std::int64_t> system) {
  return RobotReader(name, system).read(file);
}

tims::Result<EditedFile> with_parameters(const base::TextFile& file,
                                         std::optional<std::int64_t> system, std::size_t component,
                                         const std::map<std::string, std::string>& parameters) {
  EditedFile edited{.text = file.text, .changes = {}};
  Robot robot = read_robot(file, "robot", system).robot;
  for (const auto& [name, value] : parameters) {
    Component& changed = robot.components.at(component);
    const std::string option = fmt::format("--{}={}", name, value);
    std::string* old = argument(changed, name);
    if (old != nullptr && *old == option) continue;
    edited.changes.push_back({.name = name, .before = std::nullopt, .after = value});
    if (old != nullptr) {
      edited.changes.back().before = old->substr(name.size() + 3);
      *old = option;
    } else {
      changed.command.push_back(option);
    }
    edited.text = with_parameter({file.name, edited.text}, component, name, value).text;
    const RobotFile now = read_robot({file.name, edited.text}, "robot", system);
    if (!now.problems.empty())
      return refused(fmt::format("{} = {} is not possible in a robot file: {}", name, value,
                                 now.problems.front().text));
    if (now.robot.components != robot.components)
      return refused(fmt::format("{} = {} cannot be written to its component in {}; add it by hand",
                                 name, value, file.name));
  }
  return edited;
}

json::object save_parameters(RobotText& source, std::size_t component,
                             const std::map<std::string, std::string>& parameters, bool dry_run) {
  if (source.file.empty())
    throw Failure(Exit::kNoSuch, "no_robot_file",
                  "this robot was not read from a file on this host",
                  "save on the host where `timsctl up FILE` runs");
  std::error_code error;
  const std::string path = fs::canonical(source.file, error);  // resolve symbolic links
  const auto now = tims::os::read_file(path);
  if (!now)
    throw Failure(Exit::kNoSuch, "no_robot_file", "cannot read " + source.file,
                  "has it been moved?");
  if (*now != source.text)
    throw Failure(Exit::kNo, "file_changed",
                  source.file + " has changed since this robot was started from it",
                  "add the parameters by hand, or restart the robot from the file");
  const auto edited = with_parameters({source.file, *now}, source.system, component, parameters);
  if (!edited)
    throw Failure(Exit::kNo, "cannot_write", edited.error().detail(),
                  "`--dry-run` shows the changes");
  if (!dry_run && !edited->changes.empty()) {
    replace_file(path, edited->text);
    source.text = edited->text;
  }
  json::array changes;
  for (const ParameterChange& change : edited->changes)
    changes.push_back({{"name", change.name},
                       {"before", change.before ? json::value(*change.before) : json::value()},
                       {"after", change.after}});
  return {{"schema", "tims/parameters_saved/1"},
          {"file", source.file},
          {"written", !dry_run && !edited->changes.empty()},
          {"changes", std::move(changes)}};
}

// --- the components of two robot files

namespace {

std::optional<std::string_view> option_of(const tims::os::Command& command,
                                          std::string_view option) {
  const auto found = std::ranges::find_if(
      command, [&](std::string_view argument) { return argument.starts_with(option); });
  if (found == command.end()) return std::nullopt;
  return std::string_view(*found).substr(option.size());
}

}  // namespace

std::optional<std::string> component_of(const tims::os::Command& command) {
  const auto first = std::ranges::find_if(
      command, [](std::string_view argument) { return argument.starts_with("--"); });
  const auto system = option_of(command, "--system=");
  if (!system || first == command.begin()) return std::nullopt;
  const std::string& program = *std::prev(first);
  if (program.starts_with('-')) return std::nullopt;  // `ssh -oBatchMode=yes -- host ...`
  return fmt::format("{}, system {}, instance {}", program.substr(program.rfind('/') + 1), *system,
                     option_of(command, "--instance=").value_or("0"));
}

}  // namespace timsctl::robot
