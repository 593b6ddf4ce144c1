#include "router/config/load.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "router/config/nearest.h"
#include "router/config/options.h"
#include "router/config/substitute.h"
#include "router/config/toml_source.h"

namespace tims::config {
namespace {

Error wants(Kind kind, std::string_view instead) {
  return {Errc::kInvalidArgument, fmt::format("wants {}, not {}", kind_example(kind), instead)};
}

// Nearest known key; else, for a name in the wrong table, the key that has exactly this name.
std::string did_you_mean(std::string_view key) {
  std::vector<std::string_view> known;
  for (const Option& option : options()) known.push_back(option.key);
  if (const auto best = nearest(key, known)) return fmt::format("; did you mean {}?", *best);
  const std::string_view name = key.substr(key.rfind('.') + 1);
  std::string found;
  for (const Option& option : options())
    if (option.name() == name)
      found += fmt::format("{}{}", found.empty() ? "" : " or ", option.key);
  return found.empty() ? "" : fmt::format("; did you mean {}?", found);
}

bool is_table(std::string_view name) {
  return std::ranges::any_of(options(), [&](const Option& o) { return o.table() == name; });
}

std::string unknown_table(std::string_view name) {
  std::vector<std::string_view> known;
  for (const Option& option : options())
    if (known.empty() || known.back() != option.table()) known.push_back(option.table());
  if (const auto best = nearest(name, known))
    return fmt::format("unknown table [{}]; did you mean [{}]?", name, *best);
  return fmt::format("unknown table [{}]; known are {}", name, fmt::join(known, ", "));
}

Result<Value> in_range(const Option& option, const Value& value) {
  const auto checked = check_range(option.kind, option.range, value);
  return checked ? Result<Value>(value) : checked.error();
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
    check_defaults();
    check_exposure("tcp.listen", loaded_.config.tcp.listen);
    check_exposure("http.listen", loaded_.config.http.listen);
    return std::move(loaded_);
  }

 private:
  void add(const File& file) {
    TomlText text = parse_toml(file);
    for (Problem& problem : text.problems) loaded_.problems.push_back(std::move(problem));
    std::string skipped;  // the unknown table, named once instead of each of its keys
    for (const Assignment& assignment : text.assignments) {
      if (!skipped.empty() && assignment.key.starts_with(skipped)) continue;
      if (!assignment.table) {
        assign(assignment.key, assignment.value, assignment.at_key, assignment.at_value);
      } else if (!is_table(assignment.key)) {
        fail(assignment.at_key, unknown_table(assignment.key));
        skipped = assignment.key + ".";
      }
    }
  }

  void add_setting(std::string_view setting, std::uint32_t number) {
    const Origin at{.kind = Origin::Kind::kSet, .number = number};
    const std::size_t equals = setting.find('=');
    if (equals == std::string_view::npos)
      return fail(at, fmt::format("wants key=value, not {}", in_quotes(setting)));
    const std::string_view key = setting.substr(0, equals);
    std::string_view text = setting.substr(equals + 1);
    const bool is_quoted = text.size() >= 2 && text.front() == '"' && text.back() == '"';
    if (is_quoted) text = text.substr(1, text.size() - 2);
    const Option* option = find_option(key);
    if (option == nullptr) return fail_unknown(at, key);
    store(*option, parse_value(option->kind, option->range, text), at);
  }

  void assign(std::string_view key, const Raw& raw, const Origin& at_key, const Origin& at_value) {
    if (const Option* option = find_option(key))
      store(*option, typed(*option, raw), at_value);
    else if (is_table(key))
      fail(at_key, fmt::format("{0} is a table: write [{0}] once, above its keys", key));
    else
      fail_unknown(at_key, key);
  }

  // A value as TOML has it, as the option wants it.
  Result<Value> typed(const Option& option, const Raw& raw) const {
    if (const auto* text = std::get_if<std::string>(&raw)) return typed_text(option, *text);
    if (const auto* flag = std::get_if<bool>(&raw))
      return option.kind == Kind::kFlag ? Result<Value>(*flag)
                                        : wants(option.kind, *flag ? "true" : "false");
    if (const auto* number = std::get_if<std::int64_t>(&raw)) {
      if (option.kind == Kind::kNumber) return in_range(option, *number);
      if (option.kind == Kind::kSize) return in_range(option, Bytes{*number});
      return wants(option.kind, std::to_string(*number));
    }
    return wants(option.kind, std::get<Foreign>(raw).what);
  }

  Result<Value> typed_text(const Option& option, const std::string& text) const {
    const auto replaced = substitute(text, environment_);
    if (!replaced) return replaced.error();
    // A number in quotes is a mistake, unless it comes from the environment: that has only texts.
    const bool quotes_wrong = option.kind == Kind::kNumber || option.kind == Kind::kFlag;
    if (quotes_wrong && *replaced == text)
      return wants(option.kind, fmt::format("the text {}", in_quotes(text)));
    return parse_value(option.kind, option.range, *replaced);
  }

  void store(const Option& option, const Result<Value>& value, const Origin& at) {
    if (!value) return fail(at, fmt::format("{} {}", option.key, value.error().detail()));
    option.set(loaded_.config, *value);
    loaded_.origins.insert_or_assign(std::string(option.key), at);
  }

  // A default comes from the host: a path made of a long $XDG_RUNTIME_DIR may not fit.
  void check_defaults() {
    for (const Option& option : options()) {
      if (loaded_.origins.contains(option.key)) continue;
      const auto value = in_range(option, option.get(loaded_.config));
      if (!value) fail({}, fmt::format("{} {}", option.key, value.error().detail()));
    }
  }

  void check_exposure(std::string_view key, const std::optional<Endpoint>& listen) {
    if (!listen || listen->loopback() || loaded_.config.security.insecure) return;
    const auto origin = loaded_.origins.find(key);
    fail(origin == loaded_.origins.end() ? Origin{} : origin->second,
         fmt::format("{} \"{}\" is not a loopback address, and this version has no keys to protect "
                     "it: everybody who reaches the port could command the robot. Listen on "
                     "\"127.0.0.1:{}\"; or, where every machine of the network is trusted, write "
                     "\"insecure = true\" under [security] (or --set security.insecure=true)",
                     key, listen->to_string(), listen->port));
  }

  void fail_unknown(const Origin& at, std::string_view key) {
    fail(at, fmt::format("unknown key {}{}", key, did_you_mean(key)));
  }
  void fail(const Origin& at, std::string text) {
    loaded_.problems.push_back({at, std::move(text)});
  }

  const Sources& sources_;
  Environment environment_;
  Loaded loaded_;
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

}  // namespace tims::config
