#include "tools/configuration/answers.h"

#include <fmt/format.h>

#include "base/toml_edit.h"
#include "router/config/options.h"

namespace timsctl::configuration {
namespace {

void append_places(const base::TomlNode& node, base::TomlPath& path, json::object& places) {
  if (!path.empty())
    places[base::to_string(path)] = json::array{node.at_value.line, node.at_value.column};
  std::size_t index = 0;
  for (const base::TomlNode& child : node.children) {
    if (node.form == base::TomlNode::Form::kArray)
      path.emplace_back(index++);
    else
      path.emplace_back(child.key);
    append_places(child, path, places);
    path.pop_back();
  }
}

}  // namespace

json::object to_json(const Finding& finding) {
  return {{"host", finding.host}, {"file", finding.file},
          {"line", finding.line}, {"column", finding.column},
          {"path", finding.path}, {"severity", finding.is_error ? "error" : "warning"},
          {"text", finding.text}};
}

std::string sentence_of(const Finding& finding) {
  if (finding.line == 0) return finding.file + ": " + finding.text;
  return fmt::format("{}:{}:{}: {}", finding.file, finding.line, finding.column, finding.text);
}

json::array to_json(const std::vector<Finding>& findings) {
  json::array all;
  for (const Finding& each : findings) all.push_back(to_json(each));
  return all;
}

void append_values(const base::TextFile& file, json::object& row) {
  const base::TomlTree tree = base::parse_toml(file);
  json::object places;
  base::TomlPath path;
  append_places(tree.root, path, places);
  row["values"] = json_of(tree.root);
  row["places"] = std::move(places);
}

json::array files_json(const Texts& files, bool with_text) {
  json::array all;
  for (const auto& [name, text] : files) {
    json::object row{{"file", name}, {"hash", hash_of(text)}};
    if (with_text) row["text"] = text;
    all.push_back(std::move(row));
  }
  return all;
}

json::object options_json() {
  json::array items;
  const auto add = [&](const tims::config::Option& option, bool is_list) {
    const tims::config::Config usual{};
    json::object row{{"key", option.key},
                     {"list", is_list},
                     {"kind", tims::config::kind_name(option.kind)},
                     {"range", tims::config::range_text(option.kind, option.range)},
                     {"min", option.range.min},
                     {"max", option.range.max},
                     {"example", tims::config::kind_example(option.kind)},
                     {"help", option.help},
                     {"reload", is_list || option.reload == tims::config::Reload::kYes}};
    if (!is_list && option.has_value(usual, 0))
      row["default"] = tims::config::to_toml(option.get(usual));
    items.push_back(std::move(row));
  };
  for (const auto& option : tims::config::options()) add(option, false);
  for (const auto& list : tims::config::lists())
    for (const auto& option : list.options) add(option, true);
  return {{"schema", "tims/conf_options/1"}, {"items", std::move(items)}};
}

json::object to_json(const Edge& edge) {
  const auto known = [](auto number) { return number > 0 ? json::value(number) : json::value(); };
  return {{"from", edge.from.address()},
          {"component", edge.from.name},
          {"file", edge.from.file},
          {"to", edge.to},
          {"host", edge.host},
          {"to_host", edge.to_host.empty() ? json::value() : json::value(edge.to_host)},
          {"parameter", edge.parameter},
          {"period_ms", known(edge.period_ms)},
          {"bytes_max", known(edge.bytes_max)},
          {"class", edge.message_class}};
}

json::object to_json(const LinkBudget& link) {
  json::array classes;
  for (std::size_t i = 0; i < link.worst.size(); ++i) {
    const double measured = link.measured ? link.measured_by_class.at(i) : 0;
    if (link.worst.at(i) <= 0 && measured <= 0) continue;
    classes.push_back(json::object{
        {"class", i},
        {"worst_bytes_per_s", link.worst.at(i)},
        {"measured_bytes_per_s", link.measured ? json::value(measured) : json::value()}});
  }
  const bool has_cap = link.rate > 0;
  const auto share = [&](double value) { return has_cap ? json::value(value) : json::value(); };
  return {{"host", link.host},
          {"router", link.host},
          {"link", link.other},
          {"rate_bytes_per_s", has_cap ? json::value(link.rate) : json::value()},
          {"reserve_percent", link.reserve_percent},
          {"classes", std::move(classes)},
          {"worst_bytes_per_s", link.worst_sum()},
          {"worst_share", share(link.worst_share())},
          {"measured_bytes_per_s", link.measured ? json::value(*link.measured) : json::value()},
          {"measured_share", link.measured ? share(link.measured_share()) : json::value()},
          {"level", link.level()}};
}

}  // namespace timsctl::configuration
