#include "base/toml_edit.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <ranges>

#include "base/text.h"
#include "base/toml_scan.h"

namespace tims::base {
namespace {

using Node = ScannedNode;
using Form = ScannedNode::Form;

bool is_bare(std::string_view key) {
  return !key.empty() && std::ranges::all_of(key, is_bare_key_character);
}

std::string key_text(std::string_view key) {
  return is_bare(key) ? std::string(key) : in_quotes(key);
}

std::string keys_text(std::span<const std::string> keys) {
  std::string text;
  for (const std::string& key : keys) text.append(text.empty() ? "" : ".").append(key_text(key));
  return text;
}

std::string number_text(double number) {
  if (std::isnan(number)) return "nan";
  if (std::isinf(number)) return number < 0 ? "-inf" : "inf";
  std::array<char, 32> room{};
  std::string text(room.data(), std::to_chars(room.begin(), room.end(), number).ptr);
  // TOML tells a real number from a whole one by its point or exponent.
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

struct Printer {
  std::string operator()(const std::string& text) const { return in_quotes(text); }
  std::string operator()(bool flag) const { return flag ? "true" : "false"; }
  std::string operator()(std::int64_t number) const { return std::to_string(number); }
  std::string operator()(double number) const { return number_text(number); }
  std::string operator()(const TomlInput::List& list) const {
    std::string text;
    for (const TomlInput& item : list) text += (text.empty() ? "" : ", ") + item.to_toml();
    return "[" + text + "]";
  }
  std::string operator()(const TomlInput::Table& table) const {
    if (table.empty()) return "{}";
    std::string text;
    for (const auto& [key, value] : table)
      text += (text.empty() ? "" : ", ") + key_text(key) + " = " + value.to_toml();
    return "{ " + text + " }";
  }
};

// One operation on one text. Throws Problem.
class Edit {
 public:
  Edit(const TextFile& file, const TomlOperation& operation)
      : file_(file),
        text_(file.text),
        operation_(operation),
        document_(scan_toml(file.text)),
        line_end_(text_.find("\r\n") != std::string::npos ? "\r\n" : "\n") {}

  std::string run() {
    switch (operation_.kind) {
      case TomlOperation::Kind::kSet:
        set(operation_.path, operation_.value);
        break;
      case TomlOperation::Kind::kAdd:
        add();
        break;
      case TomlOperation::Kind::kRemove:
        remove();
        break;
      case TomlOperation::Kind::kRename:
        rename();
        break;
    }
    return std::move(text_);
  }

 private:
  [[noreturn]] void refuse(const Node& near, const std::string& text) const {
    const std::size_t at = std::min(near.place(), file_.text.size());
    const std::string_view before = std::string_view(file_.text).substr(0, at);
    const auto line = static_cast<std::uint32_t>(std::ranges::count(before, '\n') + 1);
    const std::string_view in_line = before.substr(before.rfind('\n') + 1);
    throw Problem{{.file = file_.name,
                   .line = line,
                   .column = static_cast<std::uint32_t>(display_width(in_line) + 1)},
                  text};
  }

  // The deepest node on the path, and how many steps lead to it.
  [[nodiscard]] std::pair<Node*, std::size_t> walk(const TomlPath& path) const {
    Node* node = document_.root.get();
    for (std::size_t i = 0; i < path.size(); ++i) {
      Node* next = node->child(path[i]);
      if (next == nullptr) return {node, i};
      node = next;
    }
    return {node, path.size()};
  }

  [[nodiscard]] std::string path_text() const { return to_string(operation_.path); }

  // --- set

  void set(const TomlPath& path, const TomlInput& value) {
    auto [node, steps] = walk(path);
    if (steps == path.size()) return replace(*node, value);
    const std::vector<std::string> keys = keys_behind(*node, path, steps);
    if (node->is_plain())
      refuse(*node,
             to_string(TomlPath(path.begin(), path.begin() + std::ssize(path) - std::ssize(keys))) +
                 " is a value, not a table");
    insert_key(*node, keys, value);
  }

  std::vector<std::string> keys_behind(const Node& node, const TomlPath& path,
                                       std::size_t steps) const {
    std::vector<std::string> keys;
    for (std::size_t i = steps; i < path.size(); ++i) {
      const auto* key = std::get_if<std::string>(&path[i]);
      if (key == nullptr || (i == steps && node.is_list()))
        refuse(node, path_text() + ": there is no such element, the list has " +
                         std::to_string(node.is_list() ? node.children.size() : 0));
      keys.push_back(*key);
    }
    return keys;
  }

  void replace(const Node& node, const TomlInput& value) {
    if (node.form == Form::kTable || node.form == Form::kTables)
      refuse(node, path_text() + " is a table: set its keys, or remove it first");
    put(node.value, value.to_toml());
  }

  // A key that is not there, in a table that is.
  void insert_key(Node& table, std::vector<std::string> keys, const TomlInput& value) {
    if (table.is_dotted()) {
      keys.insert(keys.begin(), table.dotted.begin(), table.dotted.end());
      return insert_dotted(*table.owner, keys, value);
    }
    if (table.form == Form::kInlineTable) return insert_inline(table, nested(keys, value));
    if (table.form != Form::kTable) refuse(table, path_text() + ": a list has no keys");
    if (&table == document_.root.get() && is_section(keys, value))
      return append_section(keys, value);
    if (!table.is_explicit) return insert_header(table, nested(keys, value));
    insert_line(table, nested(keys, value));
  }

  static bool is_section(const std::vector<std::string>& keys, const TomlInput& value) {
    return keys.size() > 1 || std::holds_alternative<TomlInput::Table>(value.value);
  }

  // "a = { b = 1 }" of the keys a and b.
  static std::string nested(std::span<const std::string> keys, const TomlInput& value) {
    TomlInput inner = value;
    for (std::size_t i = keys.size() - 1; i > 0; --i)
      inner = TomlInput{TomlInput::Table{{keys[i], std::move(inner)}}};
    return key_text(keys.front()) + " = " + inner.to_toml();
  }

  void insert_dotted(Node& owner, std::span<const std::string> keys, const TomlInput& value) {
    const std::string assignment = keys_text(keys) + " = " + value.to_toml();
    if (owner.form == Form::kInlineTable) return insert_inline(owner, assignment);
    insert_line(owner, assignment);
  }

  void insert_inline(const Node& table, const std::string& assignment) {
    if (table.entries.empty()) return put(table.value, "{ " + assignment + " }");
    insert(table.entries.back().end, ", " + assignment);
  }

  // Behind the last own statement of the table, with the indentation of that line.
  void insert_line(const Node& table, const std::string& assignment) {
    insert_lines(table.body_end, indentation(table) + assignment + line_end_);
  }

  [[nodiscard]] std::string indentation(const Node& table) const {
    if (table.statements.empty()) return {};
    const std::size_t begin = table.statements.back().begin;
    const std::size_t end = text_.find_first_not_of(" \t", begin);
    return text_.substr(begin, std::min(end, text_.size()) - begin);
  }

  // A table that only has tables: its header goes above the first of them.
  void insert_header(const Node& table, const std::string& assignment) {
    insert_lines(table.first_statement(),
                 "[" + header_of(table) + "]" + line_end_ + assignment + line_end_ + line_end_);
  }

  [[nodiscard]] std::string header_of(const Node& table) const {
    std::vector<std::string> keys;
    for (const Node* node = &table; node->owner != nullptr; node = node->owner) {
      if (node->is_dotted())
        keys.insert(keys.begin(), node->dotted.begin(), node->dotted.end());
      else if (!node->is_element)
        keys.insert(keys.begin(), node->key);
    }
    return keys_text(keys);
  }

  // [a.b] at the end of the text.
  void append_section(std::vector<std::string> keys, const TomlInput& value) {
    TomlInput::Table rows;
    if (const auto* table = std::get_if<TomlInput::Table>(&value.value)) {
      rows = *table;
    } else {
      rows = {{keys.back(), value}};
      keys.pop_back();
    }
    append_section("[" + keys_text(keys) + "]", rows, text_.size());
  }

  void append_section(const std::string& header, const TomlInput::Table& rows, std::size_t at) {
    std::string made = at == 0 ? "" : line_end_;
    made += header + line_end_;
    for (const auto& [key, value] : rows)
      made += key_text(key) + " = " + value.to_toml() + line_end_;
    insert_lines(at, made);
  }

  // --- add

  void add() {
    auto [node, steps] = walk(operation_.path);
    const TomlInput& value = operation_.value;
    if (steps < operation_.path.size()) return make_list(*node, steps);
    if (node->form == Form::kArray) return append_element(*node, value.to_toml());
    if (node->form != Form::kTables) refuse(*node, path_text() + " is not a list");
    const auto* rows = std::get_if<TomlInput::Table>(&value.value);
    if (rows == nullptr) refuse(*node, path_text() + " is a list of tables: add a table");
    append_section("[[" + header_of(*node) + "]]", *rows, node->last_statement());
  }

  void make_list(const Node& node, std::size_t steps) {
    const auto* rows = std::get_if<TomlInput::Table>(&operation_.value.value);
    const std::vector<std::string> keys = keys_behind(node, operation_.path, steps);
    if (rows != nullptr && steps == 0)
      return append_section("[[" + keys_text(keys) + "]]", *rows, text_.size());
    set(operation_.path, TomlInput{TomlInput::List{operation_.value}});
  }

  void append_element(const Node& list, const std::string& made) {
    if (list.children.empty()) return insert(list.value.end - 1, made);
    const Node& last = *list.children.back();
    const std::size_t line = line_begin(last.value.begin);
    const std::size_t comma = comma_behind(last.value.end);
    const std::string indent = text_.substr(line, last.value.begin - line);
    if (line <= list.value.begin || indent.find_first_not_of(" \t") != std::string::npos)
      return insert(last.value.end, ", " + made);
    // One element a line: the new one gets its own, below the comment of the last.
    const std::size_t end = line_stop(std::max(last.value.end, comma));
    if (end > list.value.end - 1) return insert(last.value.end, "," + line_end_ + indent + made);
    insert(end, line_end_ + indent + made + (comma != 0 ? "," : ""));
    if (comma == 0) insert(last.value.end, ",");
  }

  // --- remove

  void remove() {
    auto [node, steps] = walk(operation_.path);
    if (operation_.path.empty() || steps < operation_.path.size())
      refuse(*node, path_text() + " is not in this file");
    if (node->is_element && node->owner->form == Form::kArray) return remove_element(*node);
    if (node->form == Form::kTable || node->form == Form::kTables) return remove_table(*node);
    if (node->owner_of_entry().form == Form::kInlineTable) return remove_entries({node->entry});
    erase(node->statements.front());
  }

  // All statements of it, and what stands between two of them.
  void remove_table(const Node& node) {
    if (node.is_dotted() && node.owner->form == Form::kInlineTable)
      return remove_entries(node.all_entries());
    std::vector<Span> all = node.all_statements();
    std::ranges::sort(all, {}, &Span::begin);
    std::vector<Span> merged;
    for (const Span& span : all) {
      const bool follows = !merged.empty() && document_.is_next(merged.back().end, span.begin);
      if (follows)
        merged.back().end = span.end;
      else
        merged.push_back(span);
    }
    for (const Span& span : std::views::reverse(merged)) erase(span);
  }

  // Of an inline table: "a = 1" with one of the commas beside it. From the last to the first.
  void remove_entries(std::vector<Span> gone) {
    std::ranges::sort(gone, std::ranges::greater(), &Span::begin);
    for (const Span& entry : gone) {
      const std::size_t comma = comma_behind(entry.end);
      const std::size_t before = text_.find_last_not_of(" \t", entry.begin - 1);
      if (comma != 0) {
        erase({entry.begin, text_.find_first_not_of(" \t", comma)});
      } else if (text_[before] == ',') {
        erase({before, entry.end});
      } else {
        erase(entry);
      }
    }
  }

  void remove_element(const Node& element) {
    const Span value = element.value;
    const std::size_t comma = comma_behind(value.end);
    const std::size_t line = line_begin(value.begin);
    const std::size_t stop = line_stop(std::max(value.end, comma));
    const Span& list = element.owner->value;
    const bool alone = line > list.begin && stop < list.end &&
                       text_.find_first_not_of(" \t", line) == value.begin &&
                       is_blank_or_comment(std::max(value.end, comma), stop);
    const bool last = &element == element.owner->children.back().get();
    if (alone) return erase({line, line_behind(stop)});
    const std::size_t next = last ? 0 : element.owner->next_of(element).value.begin;
    if (!last && has_no_line_end(comma, next)) return erase({value.begin, next});
    const std::size_t siblings = element.owner->children.size();
    const std::size_t before =
        last && siblings > 1 ? element.owner->children[siblings - 2]->value.end : 0;
    if (before != 0 && has_no_line_end(before, value.begin)) return erase({before, value.end});
    erase({value.begin, std::max(value.end, comma)});  // a comma may stay before the bracket
  }

  [[nodiscard]] bool has_no_line_end(std::size_t begin, std::size_t end) const {
    return std::string_view(text_).substr(begin, end - begin).find('\n') == std::string::npos;
  }
  [[nodiscard]] bool is_blank_or_comment(std::size_t begin, std::size_t end) const {
    const std::size_t at = text_.find_first_not_of(" \t\r", begin);
    return at >= end || text_[at] == '#';
  }

  // --- rename

  void rename() {
    auto [node, steps] = walk(operation_.path);
    if (steps < operation_.path.size()) refuse(*node, path_text() + " is not in this file");
    const bool has_header = node->form == Form::kTable || node->form == Form::kTables;
    if (node->is_element || has_header) refuse(*node, path_text() + " is not the key of a value");
    if (node->owner->child(operation_.name) != nullptr)
      refuse(*node, path_text() + " is there as " + operation_.name + ", too: remove one of them");
    const bool in_line = node->owner_of_entry().form == Form::kInlineTable;
    std::size_t at = in_line
                         ? node->entry.begin
                         : text_.find_first_not_of(
                               " \t", std::max(document_.begin, node->statements.front().begin));
    // The last one of a dotted key.
    while (true) {
      const std::size_t end = at + key_size(std::string_view(text_).substr(at));
      const std::size_t next = text_.find_first_not_of(" \t", end);
      if (text_[next] != '.') return put({at, end}, key_text(operation_.name));
      at = text_.find_first_not_of(" \t", next + 1);
    }
  }

  // --- bytes

  // Behind the comma that follows after blanks, line ends and comments; 0: none.
  [[nodiscard]] std::size_t comma_behind(std::size_t at) const {
    while (true) {
      at = text_.find_first_not_of(" \t\r\n", at);
      if (at == std::string::npos) return 0;
      if (text_[at] == ',') return at + 1;
      if (text_[at] != '#') return 0;
      at = text_.find('\n', at);
    }
  }
  [[nodiscard]] std::size_t line_begin(std::size_t at) const {
    return at == 0 ? 0 : text_.rfind('\n', at - 1) + 1;
  }
  // Of the line's last byte, before its line end.
  [[nodiscard]] std::size_t line_stop(std::size_t at) const {
    const std::size_t end = std::min(text_.find('\n', at), text_.size());
    return end > at && text_[end - 1] == '\r' ? end - 1 : end;
  }
  [[nodiscard]] std::size_t line_behind(std::size_t at) const {
    return std::min(text_.find('\n', at), text_.size() - 1) + 1;
  }

  void put(const Span& span, const std::string& made) {
    text_.replace(span.begin, span.end - span.begin, made);
  }
  void erase(const Span& span) { text_.erase(span.begin, span.end - span.begin); }
  void insert(std::size_t at, const std::string& made) { text_.insert(at, made); }
  // Whole lines; the last line of a text may have no end.
  void insert_lines(std::size_t at, std::string made) {
    if (at > document_.begin && text_[at - 1] != '\n') made.insert(0, line_end_);
    insert(at, made);
  }

  const TextFile& file_;
  std::string text_;
  const TomlOperation& operation_;
  ScannedToml document_;
  std::string line_end_;
};

// Every value outside of `edited`, by its path.
using Values = std::vector<std::pair<std::string, const TomlNode*>>;

void append_values(const TomlNode& node, const TomlPath& edited, TomlPath& path, Values& all) {
  if (path.size() == edited.size() && path == edited) return;
  if (node.form == TomlNode::Form::kValue) all.emplace_back(to_string(path), &node);
  std::size_t index = 0;
  for (const TomlNode& child : node.children) {
    if (node.form == TomlNode::Form::kArray)
      path.emplace_back(index++);
    else
      path.emplace_back(child.key);
    append_values(child, edited, path, all);
    path.pop_back();
  }
}

Values values_beside(const TomlTree& tree, const TomlPath& edited) {
  TomlPath path;
  Values all;
  append_values(tree.root, edited, path, all);
  std::ranges::sort(all, {}, &Values::value_type::first);
  return all;
}

bool is_same(const TomlValue& a, const TomlValue& b) {
  if (a.index() != b.index()) return false;
  if (const auto* foreign = std::get_if<Foreign>(&a))
    return foreign->what == std::get<Foreign>(b).what;
  if (const auto* real = std::get_if<double>(&a))
    return *real == std::get<double>(b) || (std::isnan(*real) && std::isnan(std::get<double>(b)));
  if (const auto* list = std::get_if<std::vector<std::string>>(&a))
    return *list == std::get<std::vector<std::string>>(b);
  if (const auto* text = std::get_if<std::string>(&a)) return *text == std::get<std::string>(b);
  if (const auto* flag = std::get_if<bool>(&a)) return *flag == std::get<bool>(b);
  return std::get<std::int64_t>(a) == std::get<std::int64_t>(b);
}

// Removing an element moves those behind it.
TomlPath edited_part(const TomlOperation& operation) {
  TomlPath path = operation.path;
  if (operation.kind == TomlOperation::Kind::kRemove &&
      std::holds_alternative<std::size_t>(path.back()))
    path.pop_back();
  return path;
}

// Where its value is afterwards.
TomlPath path_behind(const TomlOperation& operation) {
  TomlPath path = operation.path;
  if (operation.kind == TomlOperation::Kind::kRename) path.back() = operation.name;
  return path;
}

// What an operation promises: the text is valid, the value is there or gone, and all other values
// are as before.
void check_result(const TextFile& before, const TextFile& after, const TomlOperation& operation) {
  const auto refused = [&](const std::string& why) {
    return Problem{{.file = before.name, .line = 1, .column = 1},
                   to_string(operation.path) + " cannot be edited here" + why};
  };
  const TomlTree old = parse_toml(before);
  const TomlTree tree = parse_toml(after);
  if (!tree.problems.empty()) throw refused(": " + tree.problems.front().text);
  const TomlPath part = edited_part(operation);
  const TomlPath behind = path_behind(operation);
  const bool is_there = find_node(tree.root, behind) != nullptr;
  const bool wanted = operation.kind != TomlOperation::Kind::kRemove;
  if (is_there != wanted && part.size() == operation.path.size()) throw refused("");
  const bool is_renamed = operation.kind == TomlOperation::Kind::kRename;
  const Values values = values_beside(tree, is_renamed ? behind : part);
  const bool same =
      std::ranges::equal(values_beside(old, part), values, [](const auto& a, const auto& b) {
        return a.first == b.first && is_same(a.second->value, b.second->value);
      });
  if (!same) throw refused(" without a change of other values");
}

}  // namespace

std::string TomlInput::to_toml() const { return std::visit(Printer{}, value); }

std::optional<TomlPath> parse_toml_path(std::string_view text) {
  TomlPath path;
  while (!text.empty()) {
    if (text.front() == '[') {
      const std::size_t end = text.find(']');
      if (end == std::string_view::npos || path.empty()) return std::nullopt;
      const auto index = parse_number<std::uint32_t>(text.substr(1, end - 1));
      if (!index) return std::nullopt;
      path.emplace_back(std::size_t{*index});
      text.remove_prefix(end + 1);
      continue;
    }
    if (!path.empty()) {
      if (text.front() != '.') return std::nullopt;
      text.remove_prefix(1);
    }
    const std::size_t size = key_size(text);
    const auto key = decoded_key(text.substr(0, size));
    if (size == 0 || !key) return std::nullopt;
    path.emplace_back(*key);
    text.remove_prefix(size);
  }
  return path.empty() ? std::nullopt : std::optional(path);
}

std::string to_string(const TomlPath& path) {
  std::string text;
  for (const TomlStep& step : path) {
    if (const auto* key = std::get_if<std::string>(&step))
      text.append(text.empty() ? "" : ".").append(key_text(*key));
    else
      text += "[" + std::to_string(std::get<std::size_t>(step)) + "]";
  }
  return text;
}

const TomlNode* find_node(const TomlNode& root, std::span<const TomlStep> path) {
  const TomlNode* node = &root;
  for (const TomlStep& step : path) {
    if (const auto* index = std::get_if<std::size_t>(&step)) {
      if (node->form != TomlNode::Form::kArray || *index >= node->children.size()) return nullptr;
      node = &node->children[*index];
      continue;
    }
    if (node->form != TomlNode::Form::kTable) return nullptr;
    const auto found =
        std::ranges::find(node->children, std::get<std::string>(step), &TomlNode::key);
    if (found == node->children.end()) return nullptr;
    node = &*found;
  }
  return node;
}

TomlEdited edited_toml(const TextFile& file, std::span<const TomlOperation> operations) {
  TomlEdited edited{.text = file.text, .problems = parse_toml(file).problems};
  if (!edited.problems.empty()) return edited;
  TextFile now = file;
  try {
    for (const TomlOperation& operation : operations) {
      if (operation.path.empty())
        throw Problem{{.file = file.name, .line = 1, .column = 1}, "an operation needs a path"};
      TextFile next{now.name, Edit(now, operation).run()};
      check_result(now, next, operation);
      now = std::move(next);
    }
    edited.text = std::move(now.text);
  } catch (const Problem& problem) {
    edited.problems.push_back(problem);
  }
  return edited;
}

}  // namespace tims::base
