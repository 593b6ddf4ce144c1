#include "tools/configuration/questions.h"

#include <algorithm>

#include <fmt/format.h>

#include "base/text.h"
#include "base/toml_edit.h"
#include "tools/configuration/answers.h"
#include "tools/configuration/effects.h"

namespace timsctl::configuration {
namespace {

constexpr std::size_t kTextMax = 200;  // of who and why
constexpr int kDepthMax = 32;

base::TomlInput input_of(const json::value& value, int depth = 0) {
  if (depth > kDepthMax) throw Refuse{"bad_argument", "a value is nested too deeply"};
  switch (value.kind()) {
    case json::kind::string:
      return {.value = std::string(value.get_string())};
    case json::kind::bool_:
      return {.value = value.get_bool()};
    case json::kind::int64:
      return {.value = value.get_int64()};
    case json::kind::double_:
      return {.value = value.get_double()};
    case json::kind::array: {
      base::TomlInput::List list;
      for (const json::value& each : value.get_array()) list.push_back(input_of(each, depth + 1));
      return {.value = std::move(list)};
    }
    case json::kind::object: {
      base::TomlInput::Table table;
      for (const auto& [key, each] : value.get_object())
        table.emplace_back(std::string(key), input_of(each, depth + 1));
      return {.value = std::move(table)};
    }
    default:
      throw Refuse{"bad_argument", "a value is a text, a number, true, false, a list or an object"};
  }
}

base::TomlOperation operation_of(const json::value& value) {
  const json::object* object = value.if_object();
  if (object == nullptr) throw Refuse{"bad_argument", "an operation is an object"};
  const std::string op = text_at(*object, "op");
  using Kind = base::TomlOperation::Kind;
  constexpr std::pair<std::string_view, Kind> kKinds[] = {
      {"set", Kind::kSet}, {"add", Kind::kAdd}, {"remove", Kind::kRemove}};
  const auto* const kind = std::ranges::find(kKinds, op, &std::pair<std::string_view, Kind>::first);
  if (kind == std::end(kKinds)) throw Refuse{"bad_argument", "op must be set, add or remove"};
  const auto path = base::parse_toml_path(text_at(*object, "path"));
  if (!path) throw Refuse{"bad_argument", "not a path: " + text_at(*object, "path")};
  base::TomlOperation made{.kind = kind->second, .path = *path};
  const json::value* written = object->if_contains("value");
  if (made.kind != Kind::kRemove) {
    if (written == nullptr) throw Refuse{"bad_argument", "set and add need a value"};
    made.value = input_of(*written);
  }
  return made;
}

FleetHost host_of(const json::value& value) {
  const json::object* object = value.if_object();
  if (object == nullptr) throw Refuse{"bad_argument", "a host is an object"};
  FleetHost host{.name = text_at(*object, "host")};
  Texts texts;
  for (const json::value& each : items_of(*object, "files")) {
    if (!each.is_object()) throw Refuse{"bad_argument", "a file is an object"};
    const std::string name = file_in(each.get_object());
    const std::string text = text_at(each.get_object(), "text");
    if (is_robot_file(name))
      host.robots.push_back({.name = name, .text = text});
    else
      texts[name] = text;
  }
  const tims::config::Loaded loaded = load_router(texts);
  if (loaded.ok()) host.router = loaded.config;
  return host;
}

}  // namespace

void refuse_if(const Refused& refused) {
  if (refused) throw Refuse{refused->code, refused->text};
}

std::string checked_text(const json::object& question, std::string_view name) {
  std::string text = base::printable(text_at(question, name));
  if (text.size() > kTextMax)
    throw Refuse{"bad_argument", fmt::format("{} has at most {} characters", name, kTextMax)};
  return text;
}

std::string change_id(const json::object& question) {
  std::string id = text_at(question, "change");
  const bool good = id.size() >= 16 && id.size() <= 32 &&
                    id.find_first_not_of("0123456789abcdef") == std::string::npos;
  if (!good) throw Refuse{"bad_argument", "change must be 16 to 32 hex digits in lower case"};
  return id;
}

tims::Duration seconds_in(const json::object& question, std::string_view name, double usual,
                          double min, double max) {
  const double value = number_at(question, name).value_or(usual);
  const bool is_allowed = value >= min && value <= max;  // NaN is not
  if (!is_allowed)
    throw Refuse{"bad_argument", fmt::format("{} must be from {} to {} seconds", name, min, max)};
  return std::chrono::duration_cast<tims::Duration>(std::chrono::duration<double>(value));
}

Generation generation_in(const json::object& question, std::string_view name) {
  const auto value = number_at(question, name);
  if (!value || *value < 1 || *value > 1e15)
    throw Refuse{"bad_argument", fmt::format("{} must be the number of a generation", name)};
  return static_cast<Generation>(*value);
}

std::string file_in(const json::object& question) {
  std::string name = text_at(question, "file");
  if (!is_file_name(name))
    throw Refuse{"bad_argument", "\"" + base::printable(name) +
                                     "\" is no configuration file: router.toml, router.d/NAME.toml "
                                     "or robots/NAME.toml"};
  return name;
}

std::vector<std::string> others_in(const json::object& question) {
  std::vector<std::string> others;
  for (const json::value& other : items_of(question, "others")) {
    const std::string address = other.is_string() ? std::string(other.get_string()) : "";
    if (!tims::Address::parse(address))
      throw Refuse{"bad_argument", "others are addresses such as \"0x01010001\""};
    others.push_back(address);
  }
  if (others.size() > kOthersMax)
    throw Refuse{"bad_argument", fmt::format("a change has at most {} hosts", kOthersMax + 1)};
  return others;
}

// The files after the edits of a question.
Texts edited(const json::object& question, const Texts& before) {
  Texts after = before;
  std::vector<Finding> conflicts;
  std::vector<Finding> problems;
  for (const json::value& each : items_of(question, "edits")) {
    const json::object* edit = each.if_object();
    if (edit == nullptr) throw Refuse{"bad_argument", "an edit is an object"};
    const std::string name = file_in(*edit);
    const auto now = before.find(name);
    const std::string base = text_at(*edit, "base");
    if (base != (now == before.end() ? std::string() : hash_of(now->second))) {
      conflicts.push_back({.file = name, .text = name + " was changed by another editor"});
      continue;
    }
    if (text_at(*edit, "remove") == "true") {
      after.erase(name);
      continue;
    }
    if (const json::value* text = edit->if_contains("text")) {
      if (!text->is_string()) throw Refuse{"bad_argument", "text must be a text"};
      after[name] = std::string(text->get_string());
    }
    std::vector<base::TomlOperation> operations;
    for (const json::value& operation : items_of(*edit, "operations"))
      operations.push_back(operation_of(operation));
    if (!operations.empty()) {
      base::TomlEdited made = base::edited_toml({name, after[name]}, operations);
      for (const base::Problem& problem : made.problems) problems.push_back(finding_of(problem));
      after[name] = std::move(made.text);
    }
    if (after[name].size() > kFileMax)
      throw Refuse{"too_big", fmt::format("{} would have more than {} bytes", name, kFileMax)};
  }
  if (after.size() > kFilesMax)
    throw Refuse{"too_big", fmt::format("there would be more than {} files", kFilesMax)};
  if (!conflicts.empty()) throw Refuse{"conflict", conflicts.front().text, conflicts};
  if (!problems.empty()) throw Refuse{"refused", sentence_of(problems.front()), problems};
  return after;
}

std::vector<FleetHost> hosts_in(const json::object& question) {
  std::vector<FleetHost> hosts;
  for (const json::value& each : items_of(question, "hosts")) hosts.push_back(host_of(each));
  if (hosts.empty() || hosts.size() > kOthersMax + 1)
    throw Refuse{"bad_argument", fmt::format("hosts must be 1 to {}", kOthersMax + 1)};
  return hosts;
}

}  // namespace timsctl::configuration
