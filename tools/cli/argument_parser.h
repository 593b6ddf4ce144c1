// Options and arguments of a program, each with the variable that takes its value, and main() of
// such a program; and the command line of programs with verbs. The implementation is the only
// source of the tools that includes CLI11, which compiles slowly.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/cli/failure.h"

namespace CLI {
class App;
}

namespace timsctl {

struct OptionRow;

struct OptionRange {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

class ArgumentParser {
 public:
  // `call`: "mcl-eval". `about` and `more`: the beginning and the end of --help.
  explicit ArgumentParser(std::string call, const std::string& about = {},
                          const std::string& more = {});
  ~ArgumentParser();
  ArgumentParser(const ArgumentParser&) = delete;
  ArgumentParser& operator=(const ArgumentParser&) = delete;

  // "FILE": a value without the name of an option before it.
  void argument(const char* name, std::string& value, const std::string& help);
  void required_argument(const char* name, std::string& value, const std::string& help);
  // All further values.
  void arguments(const char* name, std::vector<std::string>& values, const std::string& help = {});

  // `names`: "--json", "--count,-n", "--scans,!--no-scans".
  void flag(const std::string& names, bool& value, const std::string& help);

  // --help shows the default value, except that of an optional. T: string, double, int, uint32_t,
  // uint64_t, vector<uint32_t>, optional<double>, optional<uint64_t>.
  template <typename T>
  void option(const std::string& names, T& value, const std::string& help, OptionRange range = {});
  // `type`: "NAME=NUMBER". One value for each time the option is given.
  void option(const std::string& names, const char* type, std::vector<std::string>& values,
              const std::string& help);

  enum class Asked : std::uint8_t { kRun, kHelp, kVersion };
  // Throws Failure if the command line is wrong.
  Asked parse(std::span<const std::string> arguments);
  [[nodiscard]] std::string help() const;

  // main(): parses, then prints what --help or --version asks for or calls `run`, and reports its
  // Failure. Returns the exit status.
  int run(int argc, char** argv, const std::function<Exit()>& run);

 private:
  [[nodiscard]] Failure refused(const std::string& reason) const;

  std::string call_;
  std::unique_ptr<CLI::App> app_;
};

// A command line whose verb is not known yet. The options of all verbs may be anywhere in it.
struct Line {
  struct Given {
    const OptionRow* option;
    std::string value;
  };
  std::vector<std::string> arguments;  // also "-" and negative numbers
  std::vector<Given> options;
  bool help = false;
  bool version = false;
  std::string unknown{};                // "--cuont": the first option that is not in the table
  std::optional<Failure> failure = {};  // a missing value, or the value of a flag
};

// `command_begins` returns whether the last of these arguments begins a command: what follows
// belongs to that command, options as well.
using CommandBegins = std::function<bool(std::span<const std::string>)>;
Line split_line(std::span<const std::string> arguments, const CommandBegins& command_begins);

}  // namespace timsctl
