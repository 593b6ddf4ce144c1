// A TOML text as a tree of nodes that know where they stand, and a reader that takes such a tree
// apart by lists of keys and collects every problem with its place. The only file that knows the
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
  std::string name;  // as it is printed in problems
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

// What TOML has and nobody here takes: "a table", "an array of tables", "a date or time".
struct Foreign {
  std::string_view what;
};
using TomlValue =
    std::variant<std::string, bool, std::int64_t, double, std::vector<std::string>, Foreign>;

struct TomlNode {
  enum class Form : std::uint8_t { kValue, kTable, kArray };

  std::string key{};  // empty: an item of an array
  Place at_key{};
  Place at_value{};
  Form form = Form::kValue;
  TomlValue value{};                 // of kArray too, if it holds texts only; else Foreign
  std::vector<TomlNode> children{};  // of tables and arrays, in the order of the text

  [[nodiscard]] bool is_array_of_tables() const;
};

struct TomlTree {
  TomlNode root;
  std::vector<Problem> problems;  // of the text as TOML; then the root is empty
};

TomlTree parse_toml(const TextFile& file);

class TomlReader {
 public:
  using Read = std::function<void(const TomlNode&)>;
  struct Key {
    std::string_view name;
    Read read;
  };

  // Each known key's value goes to its function; the others are problems that name the nearest.
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

  // Whether it is one.
  bool text(const TomlNode& node, std::string& out);
  // Whatever stands there, as a program's argument: true is 1.
  void plain(const TomlNode& node, std::string& out);
  void number(const TomlNode& node, std::int64_t min, std::int64_t max, std::int64_t& out);
  // Whole or not, but a number.
  void real(const TomlNode& node, double min, double max, double& out);
  // Above zero unless `zero` is allowed.
  void duration(const TomlNode& node, bool zero, Duration& out);
  // The value is a text, and not as it should be.
  void refuse(const TomlNode& node, std::string text) {
    problems_.push_back({node.at_value, std::move(text)});
  }
  // "did you mean", or all there are.
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
