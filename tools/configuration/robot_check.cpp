#include "tools/configuration/robot_check.h"

#include <algorithm>

#include <fmt/format.h>

#include "base/renamed_keys.h"
#include "base/text.h"
#include "base/toml_edit.h"

namespace timsctl::configuration {
namespace {

using base::TomlNode;

std::string robot_name(std::string_view file) {
  const std::size_t slash = file.rfind('/');
  std::string name(file.substr(slash == std::string_view::npos ? 0 : slash + 1));
  if (name.ends_with(".toml")) name.resize(name.size() - 5);
  return name;
}

const TomlNode* child(const TomlNode& node, std::string_view key) {
  const auto found = std::ranges::find(node.children, key, &TomlNode::key);
  return found == node.children.end() ? nullptr : &*found;
}

class Check {
 public:
  Check(const base::TextFile& file, const Surroundings& around) : file_(file), around_(around) {}

  std::vector<Finding> run() {
    const robot::RobotFile robot = robot::read_robot(file_, robot_name(file_.name));
    for (const base::Problem& problem : robot.problems) findings_.push_back(finding_of(problem));
    for (const base::Problem& hint : robot.hints) add(hint.at, "", hint.text, false);
    if (!robot.problems.empty()) return std::move(findings_);
    base::TomlTree tree = base::parse_toml(file_);
    (void)base::rename_former_keys(tree);
    for (const Instance& each : instances_of(file_, robot, around_.describe)) {
      const TomlNode& node = child(tree.root, "component")->children.at(each.number);
      if (each.described != nullptr) check(each, node);
    }
    return std::move(findings_);
  }

 private:
  void add(const base::Place& at, const std::string& path, std::string text, bool is_error = true) {
    findings_.push_back({.file = file_.name,
                         .line = at.line,
                         .column = at.column,
                         .path = path,
                         .text = std::move(text),
                         .is_error = is_error});
  }

  void check(const Instance& each, const TomlNode& node) {
    const std::string above = fmt::format("component[{}].parameters", each.number);
    if (const TomlNode* parameters = child(node, "parameters"))
      for (const TomlNode& parameter : parameters->children)
        check(each, parameter, above + "." + parameter.key);
    for (const Description::Parameter& parameter : each.described->parameters)
      if (parameter.required && !each.values.contains(parameter.name))
        add(node.at_key, above,
            fmt::format("{} needs the parameter {}", each.name, parameter.name));
  }

  void check(const Instance& each, const TomlNode& node, const std::string& path) {
    const Description::Parameter* known = each.described->find(node.key);
    if (known == nullptr) {
      const std::vector<std::string> names = each.described->names();
      const auto near = base::nearest(node.key, names);
      return add(node.at_key, path,
                 fmt::format("{} has no parameter \"{}\"{}", each.program, node.key,
                             near ? fmt::format("; did you mean {}?", *near)
                                  : fmt::format("; `{} --help` lists them", each.program)));
    }
    const std::string& value = each.values.at(node.key);
    if (const std::string why = known->refusal(value); !why.empty())
      return add(node.at_value, path, fmt::format("{} {}", node.key, why));
    if (node.key.ends_with("TaskPrio")) check_priority(node, value, path);
    if (known->host_file && names_a_file(node.key)) check_file(node, value, path);
  }

  void check_priority(const TomlNode& node, const std::string& value, const std::string& path) {
    const auto priority = base::parse_number<int>(value);
    if (priority && *priority > 1 && *priority > around_.priority_max)
      add(node.at_value, path,
          fmt::format("{} = {}: real-time priorities up to {} are permitted here (LimitRTPRIO)",
                      node.key, value, around_.priority_max),
          false);
  }

  // Devices and files to write need not be there.
  static bool names_a_file(std::string_view parameter) {
    return parameter == "file" || parameter.ends_with("File");
  }

  void check_file(const TomlNode& node, const std::string& value, const std::string& path) {
    if (value.empty() || around_.has_file(value)) return;
    const std::vector<std::string> names = around_.files_beside(value);
    const auto near = base::nearest(value.substr(value.rfind('/') + 1), names);
    add(node.at_value, path,
        fmt::format("{}: {} is not there{}", node.key, value,
                    near ? fmt::format("; did you mean {}?", *near) : ""));
  }

  const base::TextFile& file_;
  const Surroundings& around_;
  std::vector<Finding> findings_;
};

std::map<std::string, std::string> options_of(const tims::os::Command& command) {
  std::map<std::string, std::string> values;
  for (const std::string& argument : command) {
    const std::size_t equals = argument.find('=');
    if (argument.starts_with("--") && equals != std::string::npos)
      values[argument.substr(2, equals - 2)] = argument.substr(equals + 1);
  }
  return values;
}

std::string with_unit(const std::string& value, const std::string& unit) {
  return unit.empty() ? value : value + " " + unit;
}

// What changed between two versions of one component.
void append_sentences(const robot::Component& before, const robot::Component& after,
                      const Description* described, std::vector<std::string>& sentences) {
  const std::string restart = fmt::format("; needs restart of {}", after.name);
  const auto old = options_of(before.command);
  const auto now = options_of(after.command);
  std::map<std::string, std::string> all = old;
  all.insert(now.begin(), now.end());
  const std::size_t sentences_before = sentences.size();
  for (const auto& [name, unused] : all) {
    const Description::Parameter* known = described == nullptr ? nullptr : described->find(name);
    const auto value_in = [&](const std::map<std::string, std::string>& values) {
      if (const auto found = values.find(name); found != values.end()) return found->second;
      return known == nullptr ? std::string("not set") : known->initial + " (default)";
    };
    const std::string a = value_in(old);
    const std::string b = value_in(now);
    if (a == b) continue;
    sentences.push_back(fmt::format("{} {} {} -> {}{}", after.name, name, a,
                                    with_unit(b, known == nullptr ? "" : known->unit), restart));
  }
  if (sentences.size() == sentences_before)
    sentences.push_back(fmt::format("{} is started in another way{}", after.name, restart));
}

const robot::Component* find(const robot::Robot& robot, const std::string& name) {
  const auto found = std::ranges::find(robot.components, name, &robot::Component::name);
  return found == robot.components.end() ? nullptr : &*found;
}

std::string program_of(const robot::Component& component) {
  return component.notifies ? component.command.front() : std::string();
}

}  // namespace

Finding finding_of(const base::Problem& problem) {
  return {.file = problem.at.file,
          .line = problem.at.line,
          .column = problem.at.column,
          .text = problem.text};
}

bool has_errors(const std::vector<Finding>& findings) {
  return std::ranges::any_of(findings, &Finding::is_error);
}

std::string Instance::value(std::string_view parameter) const {
  if (const auto found = values.find(std::string(parameter)); found != values.end())
    return found->second;
  const Description::Parameter* known = described == nullptr ? nullptr : described->find(parameter);
  return known == nullptr ? std::string() : known->initial;
}

std::string Instance::address() const {
  if (described == nullptr) return {};
  return fmt::format("{}({}/{})", described->class_name, system, instance);
}

std::vector<Instance> instances_of(const base::TextFile& file, const robot::RobotFile& robot,
                                   const Describe& describe) {
  std::vector<Instance> all;
  const base::TomlTree tree = base::parse_toml(file);
  const TomlNode* tables = child(tree.root, "component");
  for (std::size_t i = 0; tables != nullptr && i < robot.robot.components.size(); ++i) {
    const robot::Component& component = robot.robot.components[i];
    if (!component.notifies || i >= tables->children.size()) continue;
    Instance made{.file = file.name,
                  .name = component.name,
                  .program = component.command.front(),
                  .host = component.host,
                  .number = i,
                  .at = tables->children[i].at_key,
                  .system = robot.robot.system,
                  .values = options_of(component.command),
                  .described = describe(component.command.front())};
    made.instance = base::parse_number<std::int64_t>(made.values["instance"]).value_or(0);
    made.values.erase("system");
    made.values.erase("instance");
    all.push_back(std::move(made));
  }
  return all;
}

std::vector<Finding> check_robot(const base::TextFile& file, const Surroundings& around) {
  return Check(file, around).run();
}

RobotDifference robot_difference(const std::string& before, const std::string& after,
                                 const std::string& file, const Describe& describe) {
  const robot::Robot a = robot::read_robot({file, before}, robot_name(file)).robot;
  const robot::Robot b = robot::read_robot({file, after}, robot_name(file)).robot;
  RobotDifference made;
  if (a.name != b.name)
    made.sentences.push_back(fmt::format("the robot {} is called {}", a.name, b.name));
  if (a.system != b.system)
    made.sentences.push_back(
        fmt::format("system {} -> {}; needs restart of all", a.system, b.system));
  if (a.files != b.files) made.sentences.push_back(fmt::format("files {} -> {}", a.files, b.files));
  for (const robot::Component& old : a.components)
    if (find(b, old.name) == nullptr) {
      made.sentences.push_back(fmt::format("{} is removed", old.name));
      made.effects.emplace_back(old.name, "stop");
    }
  for (const robot::Component& now : b.components) {
    const robot::Component* old = find(a, now.name);
    if (old == nullptr) {
      made.sentences.push_back(fmt::format("{} is added", now.name));
      made.effects.emplace_back(now.name, "start");
    } else if (*old != now) {
      append_sentences(*old, now, describe(program_of(now)), made.sentences);
      made.effects.emplace_back(now.name, "restart");
    }
  }
  return made;
}

}  // namespace timsctl::configuration
