// Reads tables of a TOML tree by lists of their keys; collects every problem with its place. Pure.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "router/config/toml_source.h"
#include "tims/result.h"
#include "tims/time.h"

namespace timsctl {

using tims::config::TomlNode;

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
  // Above zero unless `zero` is allowed.
  void duration(const TomlNode& node, bool zero, tims::Duration& out);
  // The value is a text, and not as it should be.
  void refuse(const TomlNode& node, std::string text) {
    problems_.push_back({node.at_value, std::move(text)});
  }
  // "did you mean", or all there are.
  void unknown(const tims::config::Origin& at, std::string_view what, std::string_view name,
               std::span<const std::string> known);
  void add(tims::config::Problem problem) { problems_.push_back(std::move(problem)); }

  // In the order of the text.
  [[nodiscard]] std::vector<tims::config::Problem> problems() const;

 private:
  bool is(const TomlNode& node, TomlNode::Form form, std::string_view wanted);

  std::vector<tims::config::Problem> problems_;
};

// Throws Failure with all of them, a line each; there may be none.
void fail_if_any(std::span<const tims::config::Problem> problems, const std::string& code,
                 const std::string& hint);

}  // namespace timsctl
