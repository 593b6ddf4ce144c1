// One TOML text as it is nested. Goes when nobody uses it any more: base/toml.h does the same.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "router/config/load.h"

namespace tims::config {

// What TOML has and no option takes: "a table", "an array of tables", "a date".
struct Foreign {
  std::string_view what;
};
using Raw =
    std::variant<std::string, bool, std::int64_t, double, std::vector<std::string>, Foreign>;

// The text as it is nested, for files that are no router's configuration (fleets of `timsctl sim`).
struct TomlNode {
  enum class Form : std::uint8_t { kValue, kTable, kArray };

  std::string key{};  // empty: an item of an array
  Origin at_key{};
  Origin at_value{};
  Form form = Form::kValue;
  Raw value{};                       // of kValue
  std::vector<TomlNode> children{};  // of the others, in the order of the text
};

struct TomlTree {
  TomlNode root;
  std::vector<Problem> problems;  // of the text as TOML; then the root is empty
};

TomlTree parse_toml_tree(const File& file);

}  // namespace tims::config
