#include "router/config/load.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <system_error>
#include <vector>

#include <fmt/core.h>
#include <fmt/format.h>

#include "base/text.h"
#include "base/toml.h"
#include "os/file.h"
#include "router/config/options.h"

namespace tims::config {
namespace {

using base::nearest;
using base::TomlNode;

Error must_be(Kind kind, std::string_view instead) {
  return {Errc::kInvalidArgument, fmt::format("must be {}, not {}", kind_example(kind), instead)};
}

Result<Value> in_range(const Spec& option, const Value& value) {
  const auto checked = check_range(option.kind, option.range, value);
  return checked ? Result<Value>(value) : checked.error();
}

Endpoint default_udp(const Config::Security& security) {
  const bool everywhere = security.insecure || !security.keys.empty();
  return {everywhere ? "0.0.0.0" : "127.0.0.1", kLinkPort};
}

Origin origin(const base::Place& at) {
  return {.kind = Origin::Kind::kFile, .file = at.file, .line = at.line, .column = at.column};
}

class Loader {
 public:
  explicit Loader(const Sources& sources)
      : sources_(sources), environment_(sources.host.environment) {
    environment_.try_emplace("HOSTNAME", sources.host.name);
    loaded_.config = defaults(sources.host);
  }

  Loaded run() {
    for (const File& file : sources_.files) add(file);
    for (std::size_t i = 0; i < sources_.settings.size(); ++i)
      add_setting(sources_.settings[i], static_cast<std::uint32_t>(i + 1));
    if (!is_written("udp.listen")) loaded_.config.udp.listen = default_udp(loaded_.config.security);
    add_default_paths();
    check_defaults();
    for (Problem& problem : check(loaded_.config, {loaded_.origins, refused_}))
      loaded_.problems.push_back(std::move(problem));
    return std::move(loaded_);
  }

 private:
  // In a fleet every link has DDS as its fallback path.
  void add_default_paths() {
    const Config& config = loaded_.config;
    if (config.fleet.name.empty() || !kHasDds) return;
    if (config.has_keys() && !config.dds_leaves_host()) return;
    for (std::size_t i = 0; i < loaded_.config.links.size(); ++i)
      if (!is_written(fmt::format("link[{}].paths", i)))
        loaded_.config.links[i].paths = {PathKind::kUdp, PathKind::kDds};
  }

  void add(const File& file) {
    const base::TomlTree tree = base::parse_toml(file);
    const auto first = static_cast<std::ptrdiff_t>(loaded_.problems.size());
    for (const base::Problem& problem : tree.problems) fail(origin(problem.at), problem.text);
    for (const TomlNode& node : tree.root.children) add(node);
    // Keys of one table may be scattered over a file.
    std::ranges::stable_sort(loaded_.problems.begin() + first, loaded_.problems.end(), {},
                             [](const Problem& p) { return std::pair(p.at.line, p.at.column); });
  }

  // Adds a top-level node of a file. Options are one table deep: anything deeper is a value of a
  // type that no option accepts.
  void add(const TomlNode& node) {
    if (node.form == TomlNode::Form::kTable) {
      if (!open_table(node)) return;
      for (const TomlNode& value : node.children)
        assign(fmt::format("{}.{}", node.key, value.key), value);
    } else if (node.is_array_of_tables()) {
      for (const TomlNode& item : node.children) add_item(node.key, item);
    } else {
      assign(node.key, node);
    }
  }

  // Opens `[name]`; returns false when there is no such table, after reporting it.
  bool open_table(const TomlNode& table) {
    if (is_table(table.key)) return true;
    fail(origin(table.at_key),
         find_list(table.key) != nullptr ? wrong_form(table.key) : unknown_table(table.key, false));
    return false;
  }

  // Adds one item of `[[name]]`.
  void add_item(const std::string& name, const TomlNode& item) {
    const List* list = find_list(name);
    if (list == nullptr)
      return fail(origin(item.at_key),
                  is_table(name) ? wrong_form(name) : unknown_table(name, true));
    const std::size_t index = append(*list, origin(item.at_key));
    for (const TomlNode& value : item.children) {
      const Option* option = list->find(value.key);
      if (option == nullptr)
        fail_unknown(*list, index, value.key, origin(value.at_key));
      else
        store(entry_of(*list, index, *option), typed(*option, value.value), origin(value.at_value));
    }
  }

  static std::string wrong_form(std::string_view name) {
    if (find_list(name) != nullptr)
      return fmt::format("{0} is a list: write [[{0}]] above the keys of each {0}", name);
    return fmt::format("{0} is a table: write [{0}] once, above its keys", name);
  }

  // Returns the index of the new item.
  std::size_t append(const List& list, const Origin& at) {
    const std::size_t index = list.size(loaded_.config);
    list.append(loaded_.config);
    loaded_.origins.insert_or_assign(item_key(list, index), at);
    return index;
  }

  void add_setting(std::string_view setting, std::uint32_t number) {
    const Origin at{.kind = Origin::Kind::kSet, .number = number};
    const std::size_t equals = setting.find('=');
    if (equals == std::string_view::npos)
      return fail(at, fmt::format("must be key=value, not {}", in_quotes(setting)));
    const std::string_view key = setting.substr(0, equals);
    const std::string_view text = setting.substr(equals + 1);
    const std::string_view table = key.substr(0, key.find_first_of(".["));
    if (const Option* option = find_option(key))
      return store({std::string(key), option}, parse_setting(*option, text), at);
    const List* list = find_list(table);
    if (list == nullptr) return fail(at, unknown_key(key));
    if (key == list->name) return add_item_setting(*list, text, at);
    fail(at, fmt::format("{0} cannot be set alone: write [[{1}]] in a file, or give a whole {1} as "
                         "--set {2}",
                         key, list->name, list->sample_setting));
  }

  // "kind=super,to=10.9.1.1:2010": adds one item. A list in it has "+" between its elements.
  void add_item_setting(const List& list, std::string_view text, const Origin& at) {
    const std::size_t index = append(list, at);
    while (!text.empty()) {
      const std::string_view part = text.substr(0, text.find(','));
      text.remove_prefix(std::min(text.size(), part.size() + 1));
      const std::size_t equals = part.find('=');
      const std::string_view name = part.substr(0, equals);
      if (equals == std::string_view::npos)
        fail_part(list, index, part, at);
      else if (const Option* option = list.find(name); option == nullptr)
        fail_unknown(list, index, name, at);
      else if (const Entry entry = entry_of(list, index, *option); is_written(entry.key))
        fail(at, fmt::format("{} is given twice", option->key));
      else
        store(entry, parse_part(*option, part.substr(equals + 1)), at);
    }
  }

  static Result<Value> parse_part(const Option& option, std::string_view text) {
    if (!option.is_list) return parse_setting(option, text);
    std::string elements;
    for (const char each : text) each == '+' ? elements += ", " : elements += each;
    return parse_setting(option, elements);
  }

  void fail_part(const List& list, std::size_t index, std::string_view part, const Origin& at) {
    fail(at, fmt::format("{} must be key=value,key=value, such as --set {}, not {}", list.name,
                         list.sample_setting, in_quotes(part)));
    refused_.insert_or_assign(item_key(list, index), at);
  }

  // Quotes are allowed, as in a file; nothing is substituted, since the shell has done that.
  static Result<Value> parse_setting(const Option& option, std::string_view text) {
    const bool is_quoted = text.size() >= 2 && text.front() == '"' && text.back() == '"';
    if (is_quoted) text = text.substr(1, text.size() - 2);
    return parse_value(option.kind, option.range, text);
  }

  void assign(const std::string& key, const TomlNode& value) {
    if (const Option* option = find_option(key))
      store({key, option}, typed(*option, value.value), origin(value.at_value));
    else if (is_table(key) || find_list(key) != nullptr)
      fail(origin(value.at_key), wrong_form(key));
    else
      fail(origin(value.at_key), unknown_key(key));
  }

  static Entry entry_of(const List& list, std::size_t index, const Option& option) {
    return {fmt::format("{}.{}", item_key(list, index), option.name()), &option, index};
  }

  // Converts a TOML value to the type of the option.
  Result<Value> typed(const Spec& option, const base::TomlValue& raw) const {
    if (const auto* text = std::get_if<std::string>(&raw)) return typed_text(option, *text);
    if (const auto* flag = std::get_if<bool>(&raw))
      return option.kind == Kind::kFlag ? Result<Value>(*flag)
                                        : must_be(option.kind, *flag ? "true" : "false");
    if (const auto* number = std::get_if<std::int64_t>(&raw)) {
      if (option.kind == Kind::kNumber) return in_range(option, *number);
      if (option.kind == Kind::kSize) return in_range(option, Bytes{*number});
      if (option.kind == Kind::kRate) return in_range(option, Rate{*number});
      if (option.kind == Kind::kSystem)
        return parse_value(option.kind, option.range, std::to_string(*number));
      return must_be(option.kind, std::to_string(*number));
    }
    if (const auto* texts = std::get_if<std::vector<std::string>>(&raw)) {
      if (option.kind != Kind::kPaths && !option.is_list) return must_be(option.kind, "an array");
      const std::string_view between = option.is_list ? ", " : "+";
      return parse_value(option.kind, option.range, fmt::format("{}", fmt::join(*texts, between)));
    }
    if (std::holds_alternative<double>(raw))
      return must_be(option.kind, "a number with a fraction");
    return must_be(option.kind, std::get<base::Foreign>(raw).what);
  }

  Result<Value> typed_text(const Spec& option, const std::string& text) const {
    const auto replaced = substitute(text, environment_);
    if (!replaced) return replaced.error();
    // A number in quotes is a mistake unless it comes from the environment, which contains only
    // texts.
    const bool quotes_wrong = option.kind == Kind::kNumber || option.kind == Kind::kFlag ||
                              (option.kind == Kind::kSystem && text != "*");
    if (quotes_wrong && *replaced == text)
      return must_be(option.kind, fmt::format("the text {}", in_quotes(text)));
    return parse_value(option.kind, option.range, *replaced);
  }

  void store(const Entry& entry, const Result<Value>& value, const Origin& at) {
    const Option& option = *entry.option;
    if (!value) {
      refused_.insert_or_assign(entry.key, at);
      return fail(at, fmt::format("{} {}", option.key, value.error().detail()));
    }
    option.set(loaded_.config, *value, entry.index);
    loaded_.origins.insert_or_assign(entry.key, at);
  }

  [[nodiscard]] bool is_written(std::string_view key) const {
    return loaded_.origins.contains(key) || refused_.contains(key);
  }

  // Defaults come from the host: a path built from a long $XDG_RUNTIME_DIR may not fit.
  void check_defaults() {
    for (const Option& option : options()) {
      if (is_written(option.key)) continue;
      const auto value = in_range(option, option.get(loaded_.config));
      if (!value) fail({}, fmt::format("{} {}", option.key, value.error().detail()));
    }
  }

  // The unknown key may be a misspelling of a key that would otherwise be reported as missing.
  void fail_unknown(const List& list, std::size_t index, std::string_view name, const Origin& at) {
    fail(at, unknown_item_key(list, name));
    refused_.insert_or_assign(item_key(list, index), at);
  }
  void fail(const Origin& at, std::string text) {
    loaded_.problems.push_back({at, std::move(text)});
  }

  const Sources& sources_;
  Environment environment_;
  Refused refused_;
  Loaded loaded_;
};

// --- files

namespace fs = std::filesystem;

Error unreadable(const std::string& path_and_reason) {
  return {Errc::kSystem, "cannot read " + path_and_reason};
}

// The *.toml files of a folder, in alphabetical order.
Result<std::vector<fs::path>> toml_files(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> paths;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (it->path().extension() == ".toml") paths.push_back(it->path());
  if (error) return unreadable(folder.string() + ": " + error.message());
  std::ranges::sort(paths);
  return paths;
}

// --- unknown names

// Suggests the nearest known key or, for a name in the wrong table, the key with exactly this
// name.
std::string did_you_mean(std::string_view key) {
  std::vector<std::string_view> known;
  for (const Option& option : options()) known.push_back(option.key);
  for (const List& list : lists()) known.push_back(list.name);
  if (const auto best = nearest(key, known)) return fmt::format("; did you mean {}?", *best);
  const std::string_view name = key.substr(key.rfind('.') + 1);
  std::string found;
  for (const Option& option : options())
    if (option.name() == name)
      found += fmt::format("{}{}", found.empty() ? "" : " or ", option.key);
  return found.empty() ? "" : fmt::format("; did you mean {}?", found);
}

std::string in_brackets(std::string_view name, bool is_list) {
  return fmt::format("{}{}{}", is_list ? "[[" : "[", name, is_list ? "]]" : "]");
}

std::vector<std::string_view> tables() {
  std::vector<std::string_view> known;
  for (const Option& option : options())
    if (known.empty() || known.back() != option.table()) known.push_back(option.table());
  for (const List& list : lists()) known.push_back(list.name);
  return known;
}

// --- back to TOML

// A line of TOML, with the value's origin as a comment.
std::string with_origin(std::string_view line, const Origins& origins, std::string_view key) {
  const auto found = origins.find(key);
  const Origin origin = found == origins.end() ? Origin{} : found->second;
  return fmt::format("{:<36}# {}\n", line, origin.to_string());
}

// Links that are valid with the new values of these options may be invalid with the old ones.
bool lists_wait(const Config& before, const Config& after) {
  return before.router.role != after.router.role || before.router.system != after.router.system ||
         before.address != after.address || before.udp != after.udp ||
         before.security != after.security;
}

// The items of one list, before and after. Items correspond when their labels are equal: the
// first item with a label to the first one with it, the second to the second.
class ListChanges {
 public:
  ListChanges(const List& list, const Config& before, const Config& after)
      : list_(list), before_(before), after_(after), reloadable_(!lists_wait(before, after)) {}

  std::vector<Change> find() {
    std::vector<bool> found(list_.size(before_));
    std::size_t last = 0;
    bool in_order = true;
    for (std::size_t i = 0; i < list_.size(after_); ++i) {
      const std::size_t old = find_old(found, list_.label(after_, i));
      if (old == found.size()) {
        add(label(after_, i), {}, "added");
        continue;
      }
      found[old] = true;
      in_order = in_order && old >= last;
      last = old;
      compare(old, i);
    }
    for (std::size_t i = 0; i < found.size(); ++i)
      if (!found[i]) add(label(before_, i), {}, "removed");
    if (!in_order) add(std::string(list_.name), {}, "in another order");
    return std::move(changes_);
  }

 private:
  [[nodiscard]] std::size_t find_old(const std::vector<bool>& found,
                                     const std::string& label) const {
    for (std::size_t i = 0; i < found.size(); ++i)
      if (!found[i] && list_.label(before_, i) == label) return i;
    return found.size();
  }

  void compare(std::size_t old, std::size_t now) {
    for (const Option& option : list_.options) {
      const Value old_value = option.get(before_, old);
      const Value new_value = option.get(after_, now);
      if (old_value == new_value) continue;
      add(fmt::format("{} {}", label(after_, now), option.name()), to_toml(old_value),
          to_toml(new_value));
    }
  }

  [[nodiscard]] std::string label(const Config& config, std::size_t index) const {
    return fmt::format("{} {}", list_.name, in_quotes(list_.label(config, index)));
  }

  void add(std::string key, std::string before, std::string after) {
    changes_.push_back({std::move(key), std::move(before), std::move(after), reloadable_});
  }

  const List& list_;
  const Config& before_;
  const Config& after_;
  bool reloadable_;
  std::vector<Change> changes_;
};

}  // namespace

Loaded load(const Sources& sources) { return Loader(sources).run(); }

Config defaults(const Host& host) {
  Config config;
  config.router.name = host.name.empty() ? "tims" : host.name;
  const auto runtime = host.environment.find("XDG_RUNTIME_DIR");
  const bool has_runtime = runtime != host.environment.end() && runtime->second.starts_with('/');
  if (host.uid == 0)
    config.unix.path = "/run/tims/router.sock";
  else if (has_runtime)
    config.unix.path = runtime->second + "/tims/router.sock";
  else
    config.unix.path = fmt::format("/tmp/tims-{}/router.sock", host.uid);
  return config;
}

std::vector<std::string> rule_places(const Origins& origins) {
  std::vector<std::string> places;
  for (auto at = origins.find("rule[0]"); at != origins.end();
       at = origins.find(fmt::format("rule[{}]", places.size())))
    places.push_back(at->second.to_string());
  return places;
}

std::string Origin::to_string() const {
  switch (kind) {
    case Kind::kDefault:
      return "default";
    case Kind::kFile:
      return fmt::format("{}:{}", file, line);
    case Kind::kSet:
      return fmt::format("--set {}", number);
  }
  return {};
}

std::string Problem::to_string() const {
  if (at.kind != Origin::Kind::kFile) return fmt::format("{}: {}", at.to_string(), text);
  return fmt::format("{}:{}: {}", at.to_string(), at.column, text);
}

// A list of thousands of routers has less.
constexpr std::size_t kFileBytesMax = 4 << 20;

Result<std::vector<File>> read_files(const std::string& path) {
  std::vector<fs::path> paths;
  fs::path folder = path;
  if (!fs::is_directory(path)) {
    paths.emplace_back(path);
    folder.replace_extension(".d");
  }
  if (fs::is_directory(folder)) {
    auto more = toml_files(folder);
    if (!more) return more.error();
    paths.insert(paths.end(), more->begin(), more->end());
  }
  std::vector<File> files;
  for (const fs::path& each : paths) {
    auto text = os::read_file(each, kFileBytesMax);
    if (!text) return unreadable(text.error().detail());
    files.push_back({.name = each.string(), .text = std::move(*text)});
  }
  return files;
}

Result<std::string> substitute(std::string_view text, const Environment& environment) {
  std::string out;
  while (!text.empty()) {
    const std::size_t plain = std::min(text.find('$'), text.size());
    out += text.substr(0, plain);
    text.remove_prefix(plain);
    if (text.starts_with("${")) {
      const std::size_t close = text.find('}');
      if (close == std::string_view::npos)
        return Error(Errc::kInvalidArgument, "has ${ without }; write $$ for a dollar sign");
      const std::string_view name = text.substr(2, close - 2);
      const auto found = environment.find(name);
      if (found == environment.end())
        return Error(Errc::kInvalidArgument,
                     "names the environment variable " + std::string(name) + ", which is not set");
      out += found->second;
      text.remove_prefix(close + 1);
    } else if (!text.empty()) {
      out += '$';
      text.remove_prefix(text.starts_with("$$") ? 2 : 1);
    }
  }
  return out;
}

bool is_table(std::string_view name) {
  return std::ranges::any_of(options(), [&](const Option& o) { return o.table() == name; });
}

std::string unknown_key(std::string_view key) {
  return fmt::format("unknown key {}{}", key, did_you_mean(key));
}

std::string unknown_table(std::string_view name, bool is_list) {
  const auto known = tables();
  const std::string written = in_brackets(name, is_list);
  auto candidates = known;
  if (is_list) std::ranges::reverse(candidates);  // lists first
  if (const auto best = nearest(name, candidates))
    return fmt::format("unknown table {}; did you mean {}?", written,
                       in_brackets(*best, find_list(*best) != nullptr));
  return fmt::format("unknown table {}; known are {}", written, fmt::join(known, ", "));
}

std::string unknown_item_key(const List& list, std::string_view name) {
  std::vector<std::string_view> known;
  for (const Option& option : list.options) known.push_back(option.name());
  const std::string unknown = fmt::format("unknown key {}.{}", list.name, name);
  if (const auto best = nearest(name, known))
    return fmt::format("{}; did you mean {}.{}?", unknown, list.name, *best);
  return fmt::format("{}; known are {}", unknown, fmt::join(known, ", "));
}

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

// --- changes

std::vector<Change> changes(const Config& before, const Config& after) {
  std::vector<Change> all;
  for (const Option& option : options()) {
    const Value old_value = option.get(before);
    const Value new_value = option.get(after);
    if (old_value == new_value) continue;
    all.push_back({.key = std::string(option.key),
                   .before = to_toml(old_value),
                   .after = to_toml(new_value),
                   .reloadable = option.reload == Reload::kYes});
  }
  for (const List& list : lists()) {
    auto of_list = ListChanges(list, before, after).find();
    std::ranges::move(of_list, std::back_inserter(all));
  }
  return all;
}

Config reloaded(const Config& running, const Config& wanted) {
  Config config = running;
  for (const Option& option : options())
    if (option.reload == Reload::kYes) option.set(config, option.get(wanted));
  if (lists_wait(running, wanted)) return config;
  for (const List& list : lists()) list.copy(config, wanted);
  return config;
}

std::string Change::to_string() const {
  return fmt::format("{}: {}{}{}{}", key, before, before.empty() ? "" : " -> ", after,
                     reloadable ? "" : ", needs a restart");
}

}  // namespace tims::config
