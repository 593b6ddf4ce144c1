// A TOML text as a tree of nodes with their positions in the text, and a reader that processes the
// tree by lists of keys and collects every problem with its position. Only this module includes the
// TOML library.
#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "tims/time.h"

namespace tims::base {

struct TextFile {
  std::string name;  // as printed in problems
  std::string text;
};

struct Place {
  std::string file{};
  std::uint32_t line = 0;
  std::uint32_t column = 0;

  bool operator==(const Place&) const = default;
};

struct Problem {
  Place at;
  std::string text;

  [[nodiscard]] std::string to_string() const;  // "robot.toml:3:1: unknown key ..."
};

// A TOML type that no setting accepts: "a table", "an array of tables", "a date or time".
struct Foreign {
  std::string_view what;
};
using TomlValue =
    std::variant<std::string, bool, std::int64_t, double, std::vector<std::string>, Foreign>;

struct TomlNode {
  enum class Form : std::uint8_t { kValue, kTable, kArray };

  std::string key{};  // empty: an element of an array
  Place at_key{};
  Place at_value{};
  Form form = Form::kValue;
  TomlValue value{};                 // set for kArray too if it contains only texts; else Foreign
  std::vector<TomlNode> children{};  // of tables and arrays, in the order of the text

  [[nodiscard]] bool is_array_of_tables() const;
};

struct TomlTree {
  TomlNode root;
  std::vector<Problem> problems;  // syntax errors; then the root is empty
};

TomlTree parse_toml(const TextFile& file);

class TomlReader {
 public:
  using Read = std::function<void(const TomlNode&)>;
  struct Key {
    std::string_view name;
    Read read;
  };

  // Calls the function of each known key with its value; unknown keys are problems with a
  // suggestion.
  void table(const TomlNode& node, std::string_view what, std::span<const Key> keys);
  void table(const TomlNode& node, std::string_view what, std::initializer_list<Key> keys) {
    table(node, what, std::span(keys.begin(), keys.size()));
  }
  // [[what]]
  void tables(const TomlNode& node, const Read& each);
  // [what.NAME]
  void named_tables(const TomlNode& node, const Read& each);
  // ["a", "b"]
  void texts(const TomlNode& node,
             const std::function<void(const TomlNode&, const std::string&)>& each);

  // Whether the node is a text.
  bool text(const TomlNode& node, std::string& out);
  // Any scalar, in the form of a program argument: true becomes 1.
  void plain(const TomlNode& node, std::string& out);
  void number(const TomlNode& node, std::int64_t min, std::int64_t max, std::int64_t& out);
  // Any number, whole or not.
  void real(const TomlNode& node, double min, double max, double& out);
  // Must be above zero unless `zero` is allowed.
  void duration(const TomlNode& node, bool zero, Duration& out);
  // Adds a problem: the value is a text, but not a valid one.
  void refuse(const TomlNode& node, std::string text) {
    problems_.push_back({node.at_value, std::move(text)});
  }
  // Adds a problem with "did you mean", or with the list of all known keys.
  void unknown(const Place& at, std::string_view what, std::string_view name,
               std::span<const std::string> known);
  void add(Problem problem) { problems_.push_back(std::move(problem)); }

  // In the order of the text.
  [[nodiscard]] std::vector<Problem> problems() const;

 private:
  bool is(const TomlNode& node, TomlNode::Form form, std::string_view wanted);

  std::vector<Problem> problems_;
};

}  // namespace tims::base
