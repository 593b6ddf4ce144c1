#include "tools/configuration/agent.h"

#include <algorithm>
#include <filesystem>
#include <random>
#include <ranges>

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <fmt/format.h>
#include <sys/resource.h>

#include "base/measure.h"
#include "base/text.h"
#include "os/environment.h"
#include "os/file.h"
#include "os/process.h"
#include "router/config/options.h"
#include "tools/configuration/differences.h"

namespace timsctl::configuration {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kTextMax = 200;  // of who and why
constexpr int kDepthMax = 32;

// An error of PROTOCOL.md, with the findings that explain it.
struct Refuse {
  std::string code;
  std::string message;
  std::vector<Finding> findings{};
};

json::object to_json(const Finding& finding) {
  return {{"host", finding.host}, {"file", finding.file},
          {"line", finding.line}, {"column", finding.column},
          {"path", finding.path}, {"severity", finding.is_error ? "error" : "warning"},
          {"text", finding.text}};
}

// "robots/scout.toml:12:44: maxRange must be ..."
std::string sentence_of(const Finding& finding) {
  if (finding.line == 0) return finding.file + ": " + finding.text;
  return fmt::format("{}:{}:{}: {}", finding.file, finding.line, finding.column, finding.text);
}

json::array to_json(const std::vector<Finding>& findings) {
  json::array all;
  for (const Finding& each : findings) all.push_back(to_json(each));
  return all;
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

void refuse_if(const Refused& refused) {
  if (refused) throw Refuse{refused->code, refused->text};
}

template <typename T>
T need(tims::Result<T> result, const std::string& code) {
  if (!result) throw Refuse{code, result.error().detail()};
  return std::move(result).value();
}

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

// Adds the values of a text and their places, as of conf_get.
void append_values(const base::TextFile& file, json::object& row) {
  const base::TomlTree tree = base::parse_toml(file);
  json::object places;
  base::TomlPath path;
  append_places(tree.root, path, places);
  row["values"] = json_of(tree.root);
  row["places"] = std::move(places);
}

Texts router_files(const Texts& all) {
  Texts files;
  for (const auto& file : all)
    if (!is_robot_file(file.first)) files.insert(file);
  return files;
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

std::string file_in(const json::object& object) {
  std::string name = text_at(object, "file");
  if (!is_file_name(name))
    throw Refuse{"bad_argument", "\"" + base::printable(name) +
                                     "\" is no configuration file: router.toml, router.d/NAME.toml "
                                     "or robots/NAME.toml"};
  return name;
}

int real_time_max() {
  struct rlimit limit {};
  if (::getrlimit(RLIMIT_RTPRIO, &limit) != 0 || limit.rlim_max == RLIM_INFINITY) return 99;
  return static_cast<int>(std::min<rlim_t>(limit.rlim_max, 99));
}

std::string now_text() {
  return base::rfc3339(
      std::chrono::time_point_cast<base::WallTime::duration>(std::chrono::system_clock::now()));
}

std::string random_hex() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}", random(), random());
}

}  // namespace

Agent::Agent(tims::Time now, const Folder& folder, const Store& store, const Effects& effects,
             std::function<void(const std::string&)> log)
    : folder_(folder),
      store_(store),
      effects_(effects),
      log_(std::move(log)),
      change_(now, value_or_fail(store.load(), "the record of the agent")) {
  (void)value_or_fail(folder_.read(), folder_.path());
  report(now, "continued after a restart");
  do_steps(now, true);
}

// --- reading

Texts Agent::files() const { return need(folder_.read(), "cannot_read"); }

namespace {

// Programs of RACK are beside timsctl, and name its library; anybody may ask, so no others are
// started. Empty: it is none.
std::string path_of_program(const std::string& name) {
  const fs::path path = fs::path(tims::os::find_program("timsctl")).parent_path() / name;
  if (!robot::is_name(name) || !fs::is_regular_file(path)) return {};
  const auto bytes = tims::os::read_file(path);
  return bytes && bytes->find("librack") != std::string::npos ? path.string() : std::string();
}

std::optional<json::object> describe_program(const std::string& path) {
  const auto ran = tims::os::run_to_end({.command = {path, "--describe"}});
  boost::system::error_code error;
  const json::value value = json::parse(ran && ran->status.success() ? ran->output : "", error);
  if (error || !value.is_object()) return std::nullopt;
  return value.get_object();
}

}  // namespace

const Description* Agent::description(const std::string& program) {
  std::error_code error;
  const std::string path = path_of_program(program);
  if (path.empty()) return nullptr;
  const auto written = fs::last_write_time(path, error);
  auto [known, is_new] = descriptions_.try_emplace(program);
  Known& found = known->second;
  if (is_new || found.written != written) {
    const auto described = describe_program(path);
    found = {.written = written,
             .description = described ? description_of(*described) : std::nullopt};
  }
  return found.description ? &*found.description : nullptr;
}

json::object Agent::list(tims::Time now) const {
  json::array items;
  for (const auto& [name, text] : files()) {
    json::object row{{"file", name},
                     {"kind", is_robot_file(name) ? "robot" : "router"},
                     {"bytes", text.size()},
                     {"hash", hash_of(text)}};
    if (is_robot_file(name)) {
      const robot::Robot robot = robot::read_robot({name, text}, fs::path(name).stem()).robot;
      row["robot"] = robot.name;
      row["system"] = robot.system;
      row["running"] = effects_.is_running(name);
    }
    items.push_back(std::move(row));
  }
  const tims::config::Config router = load_router(files()).config;
  return {{"schema", "tims/conf_list/1"},
          {"folder", folder_.path()},
          {"router",
           json::object{{"name", router_.name},
                        {"address", router_.address},
                        {"system", router.router.system},
                        {"id", router.router.id},
                        {"role", base::trimmed(tims::config::to_toml(router.router.role), "\"")}}},
          {"widths", router_.widths},
          {"generation", change_.record().current},
          {"files", std::move(items)},
          {"change", state(now)}};
}

json::object Agent::get(const json::object& question) const {
  const std::string name = file_in(question);
  const Texts all = files();
  const auto found = all.find(name);
  if (found == all.end()) throw Refuse{"no_such_file", name + " is not there"};
  json::object row{{"schema", "tims/conf_get/1"},
                   {"file", name},
                   {"kind", is_robot_file(name) ? "robot" : "router"},
                   {"text", found->second},
                   {"hash", hash_of(found->second)}};
  append_values({name, found->second}, row);
  return row;
}

json::object Agent::describe(const json::object& question) const {
  const std::string program = text_at(question, "program");
  const std::string path = path_of_program(program);
  auto described = path.empty() ? std::nullopt : describe_program(path);
  if (!described)
    throw Refuse{"no_such_program",
                 base::printable(program) + " is no program of RACK on this host"};
  (*described)["schema"] = "tims/description/1";
  return std::move(*described);
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

json::object Agent::history(const json::object& question) const {
  const auto limit = static_cast<std::size_t>(
      std::clamp(number_at(question, "limit").value_or(kGenerationsKept), 1.0, 1000.0));
  json::array items;
  const std::vector<Item>& all = change_.record().items;
  for (auto item = all.rbegin(); item != all.rend() && items.size() < limit; ++item) {
    json::object row = configuration::to_json(*item);
    const auto files = store_.files(item->generation);
    row["files"] = files_json(files ? *files : Texts{}, false);
    row["current"] = item->generation == change_.record().current;
    items.push_back(std::move(row));
  }
  return {{"schema", "tims/conf_history/1"}, {"items", std::move(items)}};
}

json::object Agent::generation(const json::object& question) const {
  const Generation wanted = generation_in(question, "generation");
  const Item* item = change_.record().find(wanted);
  if (item == nullptr)
    throw Refuse{"no_such_generation", fmt::format("generation {} is not kept", wanted)};
  json::object row = configuration::to_json(*item);
  row["schema"] = "tims/conf_generation/1";
  row["files"] = files_json(need(store_.files(wanted), "no_such_generation"), true);
  return row;
}

json::object Agent::state(tims::Time now) const {
  const Record& record = change_.record();
  json::object made{{"schema", "tims/conf_state/1"},
                    {"generation", record.current},
                    {"state", name_of(change_.state(now))},
                    {"left_s", base::seconds(change_.left(now))},
                    {"done", done_},
                    {"last", nullptr}};
  if (const Item* item = change_.pending()) {
    made["change"] = item->change;
    made["who"] = item->who;
    made["why"] = item->why;
    made["window_s"] = base::seconds(change_.window());
    made["others"] = json::array(item->others.begin(), item->others.end());
    made["reason"] = record.pending->reason;
  } else if (const std::string holder = change_.lock_holder(now); !holder.empty()) {
    made["who"] = holder;
  }
  for (const auto& item : std::views::reverse(record.items)) {
    if (item.outcome == Outcome::kPending) continue;
    made["last"] = configuration::to_json(item);
    break;
  }
  return made;
}

// --- checking

// The files after the edits of a question.
Texts Agent::edited(const json::object& question, const Texts& before) const {
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

// Of the router's files together, and of each robot file, as far as the edits touch them.
std::vector<Finding> Agent::findings(const Texts& before, const Texts& after) {
  std::vector<Finding> all;
  if (router_files(before) != router_files(after))
    for (const tims::config::Problem& problem : load_router(after).problems)
      all.push_back({.file = problem.at.file,
                     .line = problem.at.line,
                     .column = problem.at.column,
                     .text = problem.text});
  const fs::path robots = folder_.path_of("robots");
  const Surroundings around{
      .describe = [this](const std::string& program) { return description(program); },
      .has_file = [&](const std::string& name) { return fs::exists(robots / name); },
      .files_beside =
          [&](const std::string& name) {
            std::vector<std::string> names;
            std::error_code error;
            for (const auto& entry : fs::directory_iterator((robots / name).parent_path(), error))
              names.push_back(entry.path().filename());
            return names;
          },
      .priority_max = real_time_max()};
  for (const auto& [name, text] : after) {
    const auto old = before.find(name);
    if (!is_robot_file(name) || (old != before.end() && old->second == text)) continue;
    const auto found = check_robot({name, text}, around);
    all.insert(all.end(), found.begin(), found.end());
  }
  return all;
}

json::object Agent::check(const json::object& question) {
  const Texts before = files();
  const Texts after = edited(question, before);
  const std::vector<Finding> found = findings(before, after);
  json::array changed;
  json::array effects;
  const Describe describe = [this](const std::string& program) { return description(program); };
  const auto effect = [&](std::string_view what, std::string_view file, std::string_view does) {
    effects.push_back(json::object{{"what", what}, {"file", file}, {"does", does}});
  };
  const auto text_in = [](const Texts& texts, const std::string& name) {
    const auto text = texts.find(name);
    return text == texts.end() ? std::string() : text->second;
  };
  std::vector<std::string> router_sentences;
  bool restarts = false;
  if (!has_errors(found))
    for (const auto& change :
         tims::config::changes(load_router(before).config, load_router(after).config)) {
      router_sentences.push_back(change.to_string());
      restarts = restarts || !change.reloadable;
    }
  Texts names = before;
  names.insert(after.begin(), after.end());
  for (const auto& [name, unused] : names) {
    const std::string old = text_in(before, name);
    const std::string now = text_in(after, name);
    const bool same = old == now && before.contains(name) == after.contains(name);
    if (same) continue;
    const TextDifference made = difference(name, old, now);
    std::vector<std::string> sentences;
    if (is_robot_file(name) && !has_errors(found)) {
      const RobotDifference robot = robot_difference(old, now, name, describe);
      sentences = robot.sentences;
      const bool running = effects_.is_running(name);
      for (const auto& [component, does] : robot.effects)
        effect(component, name, running ? does : "none");
    } else if (!is_robot_file(name)) {
      sentences = std::exchange(router_sentences, {});
      if (!sentences.empty()) effect("router", name, restarts ? "restart" : "reload");
    }
    json::object row{{"file", name},
                     {"hash", after.contains(name) ? json::value(hash_of(now)) : json::value()},
                     {"text", after.contains(name) ? json::value(now) : json::value()},
                     {"added", made.added},
                     {"removed", made.removed},
                     {"diff", made.diff},
                     {"sentences", json::array(sentences.begin(), sentences.end())}};
    if (after.contains(name)) append_values({name, now}, row);
    changed.push_back(std::move(row));
  }
  return {{"schema", "tims/conf_check/1"},
          {"ok", !has_errors(found)},
          {"problems", to_json(found)},
          {"files", std::move(changed)},
          {"effects", std::move(effects)}};
}

namespace {

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
  for (std::size_t i = 0; i < link.worst.size(); ++i)
    if (link.worst.at(i) > 0)
      classes.push_back(json::object{{"class", i}, {"worst_bytes_per_s", link.worst.at(i)}});
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

json::object Agent::fleet(const json::object& question) {
  std::vector<FleetHost> hosts;
  for (const json::value& each : items_of(question, "hosts")) hosts.push_back(host_of(each));
  if (hosts.empty() || hosts.size() > kOthersMax + 1)
    throw Refuse{"bad_argument", fmt::format("hosts must be 1 to {}", kOthersMax + 1)};
  FleetReport report =
      check_fleet(hosts, [this](const std::string& program) { return description(program); });
  if (text_at(question, "measured") == "true") effects_.measure(report.links);
  json::array edges;
  for (const Edge& edge : report.edges) edges.push_back(to_json(edge));
  json::array links;
  for (const LinkBudget& link : report.links) links.push_back(to_json(link));
  return {{"schema", "tims/conf_fleet/1"},
          {"ok", !has_errors(report.findings)},
          {"problems", to_json(report.findings)},
          {"order", json::array(report.order.begin(), report.order.end())},
          {"edges", std::move(edges)},
          {"links", std::move(links)}};
}

// --- changing

json::object Agent::lock(tims::Time now, const json::object& question) {
  refuse_if(change_.lock(now, change_id(question), checked_text(question, "who"),
                         seconds_in(question, "for_s", 60, 1, 600)));
  return state(now);
}

json::object Agent::apply(tims::Time now, const json::object& question) {
  const Texts before = files();
  const Texts after = edited(question, before);
  if (before == after) throw Refuse{"bad_argument", "these edits change nothing"};
  return begin(now, question, before, after);
}

json::object Agent::begin(tims::Time now, const json::object& question, const Texts& before,
                          const Texts& after) {
  Item item{.change = change_id(question),
            .who = checked_text(question, "who"),
            .why = checked_text(question, "why")};
  const tims::Duration window = seconds_in(question, "window_s", 90, 30, 600);
  for (const json::value& other : items_of(question, "others")) {
    const std::string address = other.is_string() ? std::string(other.get_string()) : "";
    if (!tims::Address::parse(address))
      throw Refuse{"bad_argument", "others are addresses such as \"0x01010001\""};
    item.others.push_back(address);
  }
  if (item.others.size() > kOthersMax)
    throw Refuse{"bad_argument", fmt::format("a change has at most {} hosts", kOthersMax + 1)};
  refuse_if(change_.may_begin(now, item.change));
  const std::vector<Finding> found = findings(before, after);
  if (has_errors(found))
    throw Refuse{"refused", sentence_of(*std::ranges::find(found, true, &Finding::is_error)),
                 found};
  keep_found(before);
  item.time = now_text();
  if (const auto kept = store_.keep(change_.next(), after); !kept)
    throw Refuse{"cannot_write", kept.error().detail()};
  done_.clear();
  refuse_if(change_.begin(now, std::move(item), window));
  do_steps(now, false);
  report(now, "");
  return state(now);
}

void Agent::keep_found(const Texts& files) {
  const auto current = store_.files(change_.record().current);
  if (change_.record().current != 0 && current && *current == files) return;
  if (const auto kept = store_.keep(change_.next(), files); !kept)
    throw Refuse{"cannot_write", kept.error().detail()};
  change_.found(now_text(), "");
  do_steps({}, false);
}

json::object Agent::undo(tims::Time now, const json::object& question) {
  if (at_path(question, "to") == nullptr) {
    refuse_if(change_.undo(now, change_id(question), "undone"));
    do_steps(now, false);
    return state(now);
  }
  const Generation wanted = generation_in(question, "to");
  if (change_.record().find(wanted) == nullptr)
    throw Refuse{"no_such_generation", fmt::format("generation {} is not kept", wanted)};
  const Texts after = need(store_.files(wanted), "no_such_generation");
  const Texts before = files();
  if (before == after)
    throw Refuse{"bad_argument", fmt::format("the files are those of generation {}", wanted)};
  return begin(now, question, before, after);
}

// Stops at steps that take time, unless `all`.
void Agent::do_steps(tims::Time now, bool all) {
  while (const Step* next = change_.step()) {
    if (next->kind == Step::Kind::kApply && !all) return;
    const Step step = *next;
    try {
      do_step(now, step);
      change_.done(now);
    } catch (const Refuse& refuse) {
      log_("error: " + refuse.message);
      change_.failed(now, refuse.message);
    }
  }
}

void Agent::do_step(tims::Time, const Step& step) {
  const auto check = [](const tims::Result<void>& done) {
    if (!done) throw Refuse{"cannot_write", done.error().detail()};
  };
  switch (step.kind) {
    case Step::Kind::kSave:
      return check(store_.save(change_.record()));
    case Step::Kind::kWrite:
      return check(folder_.write(need(store_.files(step.generation), "cannot_read")));
    case Step::Kind::kApply:
      done_ = effects_.apply(need(store_.files(step.from), "cannot_read"),
                             need(store_.files(step.generation), "cannot_read"));
  }
}

// One line whenever the state changes: nobody is to wonder why a robot behaves in another way.
void Agent::report(tims::Time now, const std::string& text) {
  const State state = change_.state(now);
  if (state == reported_) return;
  const bool was_under_way = reported_ != State::kIdle && reported_ != State::kLocked;
  reported_ = state;
  if (const Item* item = change_.pending()) {
    const std::string& reason = change_.record().pending->reason;
    log_(fmt::format("{}change {} of {} ({}): {}{}", state == State::kGoingBack ? "WARNING: " : "",
                     item->generation, item->who, item->why, name_of(state),
                     reason.empty() ? text.empty() ? "" : ", " + text : ", " + reason));
  } else if (was_under_way && !change_.record().items.empty()) {
    const Item& last = change_.record().items.back();
    log_(last.outcome == Outcome::kWentBack
             ? fmt::format(
                   "WARNING: change {} of {} went back: {}; the files are those of generation "
                   "{} again",
                   last.generation, last.who, last.reason, change_.record().current)
             : fmt::format("change {} of {} is confirmed", last.generation, last.who));
  }
}

void Agent::go_on(tims::Time now) {
  report(now, "");
  do_steps(now, true);
  report(now, "");
  change_.on_timeout(now);
  report(now, "");
  do_steps(now, true);
  report(now, "");
}

tims::Time Agent::next_timeout() const { return change_.next_timeout(); }

// --- other agents

std::vector<Agent::Peer> Agent::questions_to_peers(tims::Time now) {
  std::vector<Peer> all;
  for (const HostChange::Peer& peer : change_.peers_to_ask(now)) {
    std::string& number = asked_[peer.agent];
    number = random_hex();
    all.push_back({peer.agent, json::serialize(json::object{{"ask", "conf_peer"},
                                                            {"change", peer.change},
                                                            {"standing", name_of(peer.own)},
                                                            {"number", number}})});
  }
  return all;
}

json::object Agent::peer(tims::Time now, const json::object& question, const std::string& from) {
  const auto standing = standing_of(text_at(question, "standing"));
  const std::string change = change_id(question);
  if (!standing) throw Refuse{"bad_argument", "standing is missing"};
  change_.heard(now, from, change, *standing);
  do_steps(now, false);
  return {{"schema", "tims/conf_peer/1"},
          {"change", change},
          {"number", text_at(question, "number")},
          {"standing", name_of(change_.standing(change))}};
}

void Agent::take_answer(tims::Time now, std::string_view answer, const std::string& from) {
  boost::system::error_code error;
  const json::value value = json::parse(answer, error);
  const json::object* object = error ? nullptr : value.if_object();
  const auto asked = asked_.find(from);
  if (object == nullptr || asked == asked_.end() || text_at(*object, "number") != asked->second)
    return;
  asked_.erase(asked);
  if (const auto standing = standing_of(text_at(*object, "standing")))
    change_.answered(now, from, text_at(*object, "change"), *standing);
}

// --- questions

std::string Agent::answer(tims::Time now, std::string_view question, const std::string& from) {
  json::object made;
  try {
    boost::system::error_code error;
    const json::value value = json::parse(question, error);
    const json::object* object = error ? nullptr : value.if_object();
    if (question.size() > kQuestionMax) throw Refuse{"too_big", "a question has at most 256 KiB"};
    if (object == nullptr) throw Refuse{"bad_json", "not a JSON object"};
    made = answer_or_throw(now, *object, from);
  } catch (const Refuse& refuse) {
    made["error"] = json::object{{"code", refuse.code}, {"message", refuse.message}, {"hint", ""}};
    if (!refuse.findings.empty()) made["problems"] = to_json(refuse.findings);
  }
  made["host"] = router_.name;
  std::string text = json::serialize(made);
  if (text.size() <= kQuestionMax) return text;
  return json::serialize(
      json::object{{"host", router_.name},
                   {"error", json::object{{"code", "too_big"},
                                          {"message", "the answer would have more than 256 KiB"},
                                          {"hint", "ask about fewer files"}}}});
}

json::object Agent::answer_or_throw(tims::Time now, const json::object& question,
                                    const std::string& from) {
  const std::string ask = text_at(question, "ask");
  if (ask == "conf_list") return list(now);
  if (ask == "conf_get") return get(question);
  if (ask == "conf_options") return options_json();
  if (ask == "conf_describe") return describe(question);
  if (ask == "conf_state") return state(now);
  if (ask == "conf_history") return history(question);
  if (ask == "conf_generation") return generation(question);
  if (ask == "conf_check") return check(question);
  if (ask == "conf_fleet") return fleet(question);
  if (ask == "conf_lock") return lock(now, question);
  if (ask == "conf_apply") return apply(now, question);
  if (ask == "conf_undo") return undo(now, question);
  if (ask == "conf_peer") return peer(now, question, from);
  if (ask == "conf_unlock") {
    refuse_if(change_.unlock(now, change_id(question)));
    return state(now);
  }
  if (ask == "conf_confirm") {
    refuse_if(change_.confirm(now, change_id(question)));
    do_steps(now, false);
    return state(now);
  }
  if (ask.empty()) throw Refuse{"bad_question", "no \"ask\" in the question"};
  throw Refuse{"unknown_question", "this agent does not know \"" + base::printable(ask) + "\""};
}

}  // namespace timsctl::configuration
