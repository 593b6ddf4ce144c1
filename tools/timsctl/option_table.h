// The one table of options: how each is written, what it takes, where its value goes.
#pragma once

#include <span>
#include <string_view>

#include "tools/timsctl/options.h"

namespace timsctl {

struct OptionRow {
  std::string_view name;   // "timeout": long name, and how the table of verbs refers to it
  char letter;             // 'n' for -n, 0 without
  std::string_view value;  // "DUR"; empty: a flag. "[2]": may be left out, then it is 2
  std::string_view help;
  // Throws Failure when the value is not one.
  void (*set)(Options& options, std::string_view value);

  [[nodiscard]] bool takes_value() const { return !value.empty() && !value.starts_with('['); }
};

std::span<const OptionRow> option_table();
const OptionRow* find_option(std::string_view name);
const OptionRow* find_option(char letter);

// What -o calls it.
std::string_view form_name(Format format);

}  // namespace timsctl
