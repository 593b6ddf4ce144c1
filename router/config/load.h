// From files and `--set` to a Config, back to text, and from one Config to the next. Strict: an
// unknown key is an error that names the nearest known one; every error is reported, not only the
// first, each with the place it was written at. Texts, environment and host come in as arguments:
// only read_files touches the disk.
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

// Where a value or an error comes from.
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

using File = base::TextFile;  // its name as it is printed in errors

struct Host {
  std::string name;
  std::uint32_t uid = 0;
  std::map<std::string, std::string, std::less<>> environment;
};

struct Sources {
  // A later one overrides an earlier one, key by key; items of lists ([[link]]) come one behind the
  // other.
  std::vector<File> files;
  std::vector<std::string> settings;  // --set key=value, over all files
  Host host;
};

using Origins =
    std::map<std::string, Origin, std::less<>>;  // by key ("link[0].to"); absent = default

struct Loaded {
  Config config;  // to be used only when there are no problems
  Origins origins;
  std::vector<Problem> problems;

  [[nodiscard]] bool ok() const { return problems.empty(); }
};

Loaded load(const Sources& sources);

// The values that hold when nothing is written anywhere: the table's defaults, the host's name,
// and the socket where this user may put one.
Config defaults(const Host& host);

// Every effective value as TOML, each with a comment that says where it comes from. Loading the
// result gives the same Config.
std::string print_config(const Config& config, const Origins& origins);

// The configuration files of a path, read. A file: that file, then *.toml of the folder beside it
// that has its name with ".d" (router.toml, router.d/*.toml), in alphabetical order. A folder: its
// *.toml files.
Result<std::vector<File>> read_files(const std::string& path);

// --- parts of load()

using Environment = std::map<std::string, std::string, std::less<>>;

// ${NAME} in a text becomes the environment's value; $$ becomes a dollar sign. An unknown variable
// or an unclosed brace is an error that names it.
Result<std::string> substitute(std::string_view text, const Environment& environment);

// What is said about names that nobody knows.
bool is_table(std::string_view name);

std::string unknown_key(std::string_view key);
// Shown as it was written: "[tpc]", "[[lnk]]".
std::string unknown_table(std::string_view name, bool is_list);
std::string unknown_item_key(const List& list, std::string_view name);

// Keys that were written with a value that was refused, and items ("link[0]") with an unknown key:
// what follows from those mistakes is not told as well.
using Refused = std::map<std::string, Origin, std::less<>>;

struct Written {
  const Origins& origins;
  const Refused& refused;
};

std::vector<Problem> check(const Config& config, const Written& written);

// --- what a new configuration changes, and what of it can be had without a restart

struct Change {
  std::string key;     // "log.level"; `link "10.9.1.1:2010" rate` of a list's item
  std::string before;  // as TOML: "\"info\""; empty when items came, went or moved
  std::string after;   // as TOML; else "added", "removed", "in another order"
  bool reloadable = false;

  // "log.level: \"info\" -> \"debug\"", "link \"10.9.1.1:2010\": added"; with ", needs a restart"
  // behind it where that is so.
  [[nodiscard]] std::string to_string() const;
};

// In the order of the option table; empty when nothing changed. Links and routes do without a
// restart, unless something they were checked against (router.role, udp.listen, ...) waits for one:
// then they wait with it.
std::vector<Change> changes(const Config& before, const Config& after);

// `running` with the reloadable values of `wanted`: what a router without restart may go on with.
Config reloaded(const Config& running, const Config& wanted);

}  // namespace tims::config
