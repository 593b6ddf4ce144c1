// Converts files and `--set` to a Config, a Config to text, and computes the difference of two
// configurations. Strict: an unknown key is an error that names the nearest known one; all errors
// are reported, each with its position. Texts, environment and host are arguments: only
// read_files accesses the disk.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/toml.h"
#include "router/config/config.h"
#include "tims/result.h"

namespace tims::config {

struct List;

// The origin of a value or an error.
struct Origin {
  enum class Kind : std::uint8_t { kDefault, kFile, kSet };
  Kind kind = Kind::kDefault;
  std::string file{};
  std::uint32_t line = 0;    // kFile
  std::uint32_t column = 0;  // kFile
  std::uint32_t number = 0;  // kSet: the first --set is 1

  [[nodiscard]] std::string to_string() const;  // "default", "router.toml:3", "--set 2"
  bool operator==(const Origin&) const = default;
};

struct Problem {
  Origin at;
  std::string text;

  [[nodiscard]] std::string to_string() const;  // "router.toml:3:1: unknown key ..."
};

using File = base::TextFile;  // the name as printed in errors

struct Host {
  std::string name;
  std::uint32_t uid = 0;
  std::map<std::string, std::string, std::less<>> environment;
};

struct Sources {
  // A later file overrides an earlier one, key by key; items of lists ([[link]]) are appended.
  std::vector<File> files;
  std::vector<std::string> settings;  // --set key=value, applied after all files
  Host host;
};

using Origins =
    std::map<std::string, Origin, std::less<>>;  // by key ("link[0].to"); absent = default

struct Loaded {
  Config config;  // valid only when there are no problems
  Origins origins;
  std::vector<Problem> problems;

  [[nodiscard]] bool ok() const { return problems.empty(); }
};

Loaded load(const Sources& sources);

// The values that apply without any configuration: the table's defaults, the host's name, and a
// socket path that this user may use.
Config defaults(const Host& host);

// Every effective value as TOML, each with its origin as a comment. Loading the result yields the
// same Config.
std::string print_config(const Config& config, const Origins& origins);

// Reads the configuration files of a path. For a file: the file itself, then *.toml in the folder
// beside it with the same name and ".d" (router.toml, router.d/*.toml), in alphabetical order.
// For a folder: its *.toml files.
Result<std::vector<File>> read_files(const std::string& path);

// --- parts of load()

using Environment = std::map<std::string, std::string, std::less<>>;

// Replaces ${NAME} in a text by the value of the environment variable, and $$ by a dollar sign.
// An unknown variable or an unclosed brace is an error that names it.
Result<std::string> substitute(std::string_view text, const Environment& environment);

// Messages about unknown names.
bool is_table(std::string_view name);

std::string unknown_key(std::string_view key);
// In the notation of the file: "[tpc]", "[[lnk]]".
std::string unknown_table(std::string_view name, bool is_list);
std::string unknown_item_key(const List& list, std::string_view name);

// Keys with a refused value, and items ("link[0]") with an unknown key: errors that follow from
// these mistakes are not reported.
using Refused = std::map<std::string, Origin, std::less<>>;

struct Written {
  const Origins& origins;
  const Refused& refused;
};

std::vector<Problem> check(const Config& config, const Written& written);

// Where each [[rule]] is written: "router.toml:12".
std::vector<std::string> rule_places(const Origins& origins);

// What is allowed, and dangerous: sentences for users that say what to do. Of a valid
// configuration.
std::vector<std::string> cautions(const Config& config);

// --- effects of a new configuration, and which of them need no restart

struct Change {
  std::string key;     // "log.level"; for an item of a list `link "10.9.1.1:2010" rate`
  std::string before;  // as TOML: "\"info\""; empty when items were added, removed or reordered
  std::string after;   // as TOML; else "added", "removed", "in another order"
  bool reloadable = false;

  // "log.level: \"info\" -> \"debug\"", "link \"10.9.1.1:2010\": added"; followed by ", needs a
  // restart" where necessary.
  [[nodiscard]] std::string to_string() const;
};

// In the order of the option table; empty when nothing changed. Links and routes need no restart,
// unless an option they were checked against (router.role, udp.listen, ...) needs one: then they
// wait with it.
std::vector<Change> changes(const Config& before, const Config& after);

// `running` with the reloadable values of `wanted`: the configuration to continue with without a
// restart.
Config reloaded(const Config& running, const Config& wanted);

}  // namespace tims::config
