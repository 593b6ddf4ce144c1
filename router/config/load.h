// From files and `--set` to a Config. Pure: texts, environment and host come in as arguments
// (files.h reads the files). Strict: an unknown key is an error that names the nearest known one.
// Every error is reported, not only the first, each with the place it was written at.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "router/config/config.h"

namespace tims::config {

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

struct File {
  std::string name;  // as it is printed in errors
  std::string text;
};

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

}  // namespace tims::config
