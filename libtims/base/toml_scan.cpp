#include "base/toml_scan.h"

#include <algorithm>

#include "base/toml.h"

namespace tims::base {
namespace {

using Node = ScannedNode;
using Form = ScannedNode::Form;

class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {
    result_.root = std::make_unique<Node>();
    result_.root->form = Form::kTable;
    result_.root->is_explicit = true;
  }

  ScannedToml run() {
    if (text_.starts_with("\xEF\xBB\xBF")) at_ = 3;
    result_.begin = result_.root->body_end = at_;
    table_ = result_.root.get();
    while (skip_to_statement()) statement();
    return std::move(result_);
  }

 private:
  [[nodiscard]] bool is_at(std::string_view what) const {
    return text_.substr(at_).starts_with(what);
  }
  [[nodiscard]] bool is_end() const { return at_ >= text_.size(); }
  void skip(std::string_view any) {
    at_ = std::min(text_.find_first_not_of(any, at_), text_.size());
  }
  void skip_blanks() { skip(" \t"); }
  void skip_comment() {
    if (is_at("#")) at_ = std::min(text_.find('\n', at_), text_.size());
  }
  void skip_blanks_and_lines() {
    for (skip(" \t\r\n"); is_at("#"); skip(" \t\r\n")) skip_comment();
  }
  bool skip_to_statement() {
    skip_blanks_and_lines();
    return !is_end();
  }

  void statement() {
    const std::size_t line = std::max(text_.rfind('\n', at_) + 1, result_.begin);
    const Span place{line, 0};
    if (is_at("[["))
      list_header(place);
    else if (is_at("["))
      table_header(place);
    else
      assignment(place);
  }

  // The line's end with it.
  Span finish(Span statement) {
    skip_blanks();
    skip_comment();
    at_ = std::min(text_.find('\n', at_), text_.size() - 1) + 1;
    statement.end = at_;
    result_.statements.push_back(statement);
    return statement;
  }

  std::vector<std::string> keys() {
    std::vector<std::string> all;
    while (true) {
      skip_blanks();
      const std::size_t size = key_size(text_.substr(at_));
      all.push_back(decoded_key(text_.substr(at_, size)).value_or(std::string()));
      at_ += size;
      skip_blanks();
      if (!is_at(".") || size == 0) return all;
      ++at_;
    }
  }

  static Node& add(Node& owner, Form form, const std::string& key) {
    auto made = std::make_unique<Node>();
    made->form = form;
    made->key = key;
    made->owner = &owner;
    owner.children.push_back(std::move(made));
    return *owner.children.back();
  }
  static Node& element(Node& list, Form form) {
    Node& made = add(list, form, {});
    made.is_element = true;
    return made;
  }

  static Node* find(Node& table, const std::string& key) { return table.child(key); }

  // The table above the last key of a header.
  [[nodiscard]] Node& above(const std::vector<std::string>& keys) const {
    Node* node = result_.root.get();
    for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
      Node* next = find(*node, keys[i]);
      if (next == nullptr) next = &add(*node, Form::kTable, keys[i]);
      if (next->form == Form::kTables) next = next->children.back().get();
      node = next;
    }
    return *node;
  }

  void begin_table(Node& table, const Span& place) {
    at_ = std::min(text_.find(']', at_), text_.size() - 1) + 1;
    if (is_at("]")) ++at_;
    table.is_explicit = true;
    table.statements.push_back(finish(place));
    table.body_end = at_;
    table_ = &table;
  }

  void table_header(const Span& place) {
    ++at_;
    const std::vector<std::string> path = keys();
    Node& parent = above(path);
    Node* table = find(parent, path.back());
    if (table == nullptr) table = &add(parent, Form::kTable, path.back());
    begin_table(*table, place);
  }

  void list_header(const Span& place) {
    at_ += 2;
    const std::vector<std::string> path = keys();
    Node& parent = above(path);
    Node* list = find(parent, path.back());
    if (list == nullptr) list = &add(parent, Form::kTables, path.back());
    begin_table(element(*list, Form::kTable), place);
  }

  void assignment(const Span& place) {
    Node& made = key_and_value(*table_);
    const Span line = finish(place);
    made.statements.push_back(line);
    table_->statements.push_back(line);
    table_->body_end = line.end;
  }

  // a.b.c = value, in a table or an inline table.
  Node& key_and_value(Node& table) {
    const std::size_t begin = at_;
    const std::vector<std::string> path = keys();
    Node* node = &table;
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
      Node* next = find(*node, path[i]);
      if (next == nullptr) {
        next = &add(*node, Form::kTable, path[i]);
        next->owner = &table;
        next->dotted.assign(path.begin(), path.begin() + static_cast<std::ptrdiff_t>(i) + 1);
      }
      node = next;
    }
    Node& made = add(*node, Form::kValue, path.back());
    if (node->is_dotted()) made.owner = node;
    at_ = std::min(text_.find('=', at_), text_.size() - 1) + 1;
    skip_blanks();
    value(made);
    made.entry = {begin, made.value.end};
    return made;
  }

  void value(Node& node) {
    node.value.begin = at_;
    if (is_at("["))
      array(node);
    else if (is_at("{"))
      inline_table(node);
    else if (is_at("\"") || is_at("'"))
      at_ += key_size(text_.substr(at_));
    else
      bare();
    node.value.end = at_;
  }

  // A number, flag, date or time; a date and its time may have a blank between them.
  void bare() {
    const std::size_t begin = at_;
    at_ = std::min(text_.find_first_of(",]}#\r\n", at_), text_.size());
    at_ = std::max(text_.find_last_not_of(" \t", at_ - 1) + 1, begin);
  }

  void array(Node& node) {
    node.form = Form::kArray;
    ++at_;
    while (true) {
      skip_blanks_and_lines();
      if (is_end() || is_at("]")) break;
      value(element(node, Form::kValue));
      skip_blanks_and_lines();
      if (is_at(",")) ++at_;
    }
    ++at_;
  }

  void inline_table(Node& node) {
    node.form = Form::kInlineTable;
    ++at_;
    while (true) {
      skip_blanks_and_lines();
      if (is_end() || is_at("}")) break;
      node.entries.push_back(key_and_value(node).entry);
      skip_blanks_and_lines();
      if (is_at(",")) ++at_;
    }
    ++at_;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  ScannedToml result_;
  Node* table_ = nullptr;
};

// Bytes of a text in quotes, of one line or several.
std::size_t quoted_size(std::string_view text) {
  const char quote = text.front();
  const std::string three(3, quote);
  const bool is_long = text.starts_with(three);
  std::size_t at = is_long ? 3 : 1;
  while (at < text.size()) {
    if (text[at] == '\\' && quote == '"') {
      at += 2;
    } else if (is_long && text.substr(at).starts_with(three)) {
      // Up to two quotes before the closing ones belong to the text.
      for (at += 3; at < text.size() && text[at] == quote; ++at) {
      }
      return at;
    } else if (!is_long && text[at] == quote) {
      return at + 1;
    } else {
      ++at;
    }
  }
  return text.size();
}

}  // namespace

bool is_bare_key_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
         c == '_';
}

std::size_t key_size(std::string_view text) {
  if (text.starts_with('"') || text.starts_with('\'')) return quoted_size(text);
  const auto* const end = std::ranges::find_if_not(text, is_bare_key_character);
  return static_cast<std::size_t>(end - text.begin());
}

std::optional<std::string> decoded_key(std::string_view written) {
  if (written.empty()) return std::nullopt;
  if (is_bare_key_character(written.front())) return std::string(written);
  const TomlTree tree = parse_toml({"", std::string(written) + " = 0"});
  if (!tree.problems.empty() || tree.root.children.size() != 1) return std::nullopt;
  return tree.root.children.front().key;
}

ScannedToml scan_toml(std::string_view text) { return Scanner(text).run(); }

bool ScannedToml::is_next(std::size_t end, std::size_t next) const {
  return std::ranges::none_of(
      statements, [&](const Span& other) { return other.begin >= end && other.begin < next; });
}

ScannedNode* ScannedNode::child(const std::variant<std::string, std::size_t>& step) {
  if (const auto* index = std::get_if<std::size_t>(&step))
    return is_list() && *index < children.size() ? children[*index].get() : nullptr;
  const auto& name = std::get<std::string>(step);
  if (is_list() || is_plain()) return nullptr;
  const auto found = std::ranges::find_if(
      children, [&](const std::unique_ptr<ScannedNode>& each) { return each->key == name; });
  return found == children.end() ? nullptr : found->get();
}

std::size_t ScannedNode::place() const {
  if (value.end != 0) return entry.end != 0 ? entry.begin : value.begin;
  const std::vector<Span> all = all_statements();
  return all.empty() ? 0 : std::ranges::min(all, {}, &Span::begin).begin;
}

const ScannedNode& ScannedNode::owner_of_entry() const {
  return owner->is_dotted() ? *owner->owner : *owner;
}

const ScannedNode& ScannedNode::next_of(const ScannedNode& element) const {
  const auto found = std::ranges::find(children, &element, &std::unique_ptr<ScannedNode>::get);
  return **std::next(found);
}

std::vector<Span> ScannedNode::all_statements() const {
  std::vector<Span> all = statements;
  for (const auto& each : children)
    for (const Span& span : each->all_statements())
      if (std::ranges::find(all, span) == all.end()) all.push_back(span);
  return all;
}

std::vector<Span> ScannedNode::all_entries() const {
  if (!is_dotted()) return {entry};
  std::vector<Span> all;
  for (const auto& each : children)
    for (const Span& span : each->all_entries()) all.push_back(span);
  return all;
}

std::size_t ScannedNode::first_statement() const {
  const std::vector<Span> all = all_statements();
  return all.empty() ? 0 : std::ranges::min(all, {}, &Span::begin).begin;
}

std::size_t ScannedNode::last_statement() const {
  const std::vector<Span> all = all_statements();
  return all.empty() ? 0 : std::ranges::max(all, {}, &Span::end).end;
}

}  // namespace tims::base
