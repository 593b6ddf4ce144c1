// Options and arguments of a program or a verb, each with the variable or function that takes its
// value; and main() of programs without verbs. The implementation is the only source of the tools
// that includes CLI11, which compiles slowly.
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

struct OptionRange {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

class ArgumentParser {
 public:
  // `call`: "mcl-eval", "timsctl-sim up". `about` and `more`: the beginning and the end of --help.
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
  // The same for a command: from its first argument on, options belong to the command.
  void command(std::vector<std::string>& values);

  // `names`: "--json", "--count,-n", "--scans,!--no-scans".
  void flag(const std::string& names, bool& value, const std::string& help);
  void flag(const std::string& names, std::function<void()> set);

  // --help shows the default value, except that of an optional. T: string, double, int, uint32_t,
  // uint64_t, vector<uint32_t>, optional<double>, optional<uint64_t>.
  template <typename T>
  void option(const std::string& names, T& value, const std::string& help, OptionRange range = {});
  // `type`: "NAME=NUMBER". One value for each time the option is given.
  void option(const std::string& names, const char* type, std::vector<std::string>& values,
              const std::string& help);
  void option(const std::string& names, std::string_view type,
              const std::function<void(const std::string&)>& set);

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
  std::vector<std::string>* command_ = nullptr;
};

}  // namespace timsctl
