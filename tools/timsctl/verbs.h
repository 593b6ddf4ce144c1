// The one table of verbs. Parsing, --help, completion and the README are made from it.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "tools/timsctl/exit_code.h"

namespace timsctl {

class Context;

// What -o may say: text for people; also a message a line; also rows that are all alike.
inline constexpr std::string_view kTexts = "table wide json";
inline constexpr std::string_view kLines = "table wide json csv";
inline constexpr std::string_view kRows = "table wide plain json csv name";

struct Verb {
  std::string_view noun;
  std::string_view verb;       // empty: the noun is the whole command
  std::string_view arguments;  // "ADDR [TYPE]"
  std::size_t arguments_min;
  std::size_t arguments_max;
  std::string_view options;  // beyond the general ones, as the option table names them
  bool endless;              // runs until Ctrl-C unless told otherwise: then Ctrl-C is its end
  std::string_view help;
  std::string_view example;
  Exit (*run)(Context& context);
  std::string_view forms = kTexts;  // of -o

  [[nodiscard]] std::string name() const;  // "route show"
};

std::span<const Verb> verbs();
// Options every verb takes, and those of every verb that shows something once.
inline constexpr std::string_view kGeneralOptions =
    "host router json json-lines output timeout quiet verbose no-color utc";
inline constexpr std::string_view kShowOptions = "watch count once sort";

// What the first words name. Unique prefixes are enough; `route` alone is `route show`.
struct Resolved {
  const Verb* verb = nullptr;  // nullptr: only a noun, or nothing
  std::string_view noun;       // empty: nothing
  std::size_t words = 0;       // how many of the words it took
};
// Throws Failure for words that name nothing, or more than one thing.
Resolved resolve(std::span<const std::string> words);

}  // namespace timsctl
