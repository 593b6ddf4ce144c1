// Edits a TOML text by operations on its values. What is not edited stays byte for byte: comments,
// order, blanks, line ends. A text is first read by the TOML library, so only valid texts are
// edited, and the result is read again before it is returned.
//
// The editor finds the bytes of every statement, key and value by a scan of its own: the library
// knows where a value begins, but not where a statement with its comment ends. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "base/toml.h"

namespace tims::base {

// A value that is written into a text.
struct TomlInput {
  using List = std::vector<TomlInput>;
  using Table = std::vector<std::pair<std::string, TomlInput>>;
  std::variant<std::string, bool, std::int64_t, double, List, Table> value;

  // As TOML in one line: `{ program = "Scan2d", parameters = { maxRange = 8000 } }`.
  [[nodiscard]] std::string to_toml() const;
};

// One step of a path: a key, or the index of an element.
using TomlStep = std::variant<std::string, std::size_t>;
using TomlPath = std::vector<TomlStep>;

// `component[2].parameters."odd key"`. Empty: not a path.
std::optional<TomlPath> parse_toml_path(std::string_view text);
std::string to_string(const TomlPath& path);
// The node at the path; null: there is none.
const TomlNode* find_node(const TomlNode& root, std::span<const TomlStep> path);

struct TomlOperation {
  enum class Kind : std::uint8_t {
    kSet,     // replaces a value, or adds the key and the tables above it
    kAdd,     // appends an element to a list; makes the list
    kRemove,  // a key, table or element, with the comment on its line
    kRename,  // a key of a value
  };
  Kind kind = Kind::kSet;
  TomlPath path{};
  TomlInput value{};   // of kSet and kAdd
  std::string name{};  // of kRename: the new key, in place of the path's last step
};

struct TomlEdited {
  std::string text;               // unchanged if there are problems
  std::vector<Problem> problems;  // with the place in the text that was edited
};

// All operations, in order, or none.
TomlEdited edited_toml(const TextFile& file, std::span<const TomlOperation> operations);

}  // namespace tims::base
