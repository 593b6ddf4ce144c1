#include "base/toml_edit.h"

#include <algorithm>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/text.h"

namespace tims::base {
namespace toml_edit_test {

using Kind = TomlOperation::Kind;
using List = TomlInput::List;
using Table = TomlInput::Table;

TomlInput number(std::int64_t value) { return {.value = value}; }
TomlInput text(const std::string& value) { return {.value = value}; }

std::string edited(const std::string& before, Kind kind, const std::string& path,
                   const TomlInput& value = {}) {
  const auto parsed = parse_toml_path(path);
  if (!parsed) return "not a path: " + path;
  const TomlOperation operation{.kind = kind, .path = *parsed, .value = value};
  const TomlEdited result = edited_toml({"f", before}, {&operation, 1});
  return result.problems.empty() ? result.text : "f: " + result.problems.front().to_string();
}
std::string set(const std::string& before, const std::string& path, const TomlInput& value) {
  return edited(before, Kind::kSet, path, value);
}
std::string added(const std::string& before, const std::string& path, const TomlInput& value) {
  return edited(before, Kind::kAdd, path, value);
}
std::string removed(const std::string& before, const std::string& path) {
  return edited(before, Kind::kRemove, path);
}

TEST(TomlPath, IsKeysAndIndexes) {
  for (const std::string good : {"a", "a.b", "a[0]", "a[12].b.c[3][4]", "a.\"b c\".d", "a-b_c.1"}) {
    const auto path = parse_toml_path(good);
    ASSERT_TRUE(path) << good;
    EXPECT_EQ(to_string(*path), good);
  }
  for (const std::string bad : {"", ".", "a.", ".a", "a..b", "[0]", "a[", "a[]", "a[x]", "a[-1]",
                                "a b", "a[0]b", "\"a", "a[99999999999]", R"(a."\q")"})
    EXPECT_FALSE(parse_toml_path(bad)) << bad;
}

TEST(TomlEdit, SetReplacesTheBytesOfAValue) {
  EXPECT_EQ(set("# head\na = 1   # why\r\nb=2", "a", number(5)), "# head\na = 5   # why\r\nb=2");
  EXPECT_EQ(set("a = \"\"\"x\ny\"\"\"\"\" # c\n", "a", text("z\"")), "a = \"z\\\"\" # c\n");
  EXPECT_EQ(set("[[c]]\np = { m = 1, n = 'x' }\n[[c]]\np = {m=1,n=2}\n", "c[1].p.m", number(9)),
            "[[c]]\np = { m = 1, n = 'x' }\n[[c]]\np = {m=9,n=2}\n");
  EXPECT_EQ(set("a = [\n  1, # one\n  2, # two\n]\n", "a[1]", number(3)),
            "a = [\n  1, # one\n  3, # two\n]\n");
  EXPECT_EQ(set("when = 1979-05-27 07:32:00 # c\n", "when", number(3)), "when = 3 # c\n");
}

TEST(TomlEdit, SetAddsAKeyBehindTheOthersOfItsTable) {
  EXPECT_EQ(set("[a]\n  x = 1 # c\n\n# of b\n[b]\n", "a.y", number(2)),
            "[a]\n  x = 1 # c\n  y = 2\n\n# of b\n[b]\n");
  EXPECT_EQ(set("[a]\nx = 1", "a.y", number(2)), "[a]\nx = 1\ny = 2\n");
  EXPECT_EQ(set("[a]\r\nx = 1\r\n", "a.y", text("")), "[a]\r\nx = 1\r\ny = \"\"\r\n");
  EXPECT_EQ(set("p = {}\n", "p.a", number(1)), "p = { a = 1 }\n");
  EXPECT_EQ(set("p = { a = 1 } # c\n", "p.b", number(2)), "p = { a = 1, b = 2 } # c\n");
  EXPECT_EQ(set("p = { a.b = 1 }\n", "p.a.c", number(2)), "p = { a.b = 1, a.c = 2 }\n");
  EXPECT_EQ(set("a.b = 1\n", "a.c", number(2)), "a.b = 1\na.c = 2\n");
  EXPECT_EQ(set("", "a", number(1)), "a = 1\n");
}

TEST(TomlEdit, SetMakesTheTablesAboveAKey) {
  EXPECT_EQ(set("x = 1\n", "tcp.listen", text("off")), "x = 1\n\n[tcp]\nlisten = \"off\"\n");
  EXPECT_EQ(set("[[c]]\nprogram = \"A\"\n", "c[0].parameters.m", number(1)),
            "[[c]]\nprogram = \"A\"\nparameters = { m = 1 }\n");
  EXPECT_EQ(set("[a.b]\nx = 1\n", "a.y", number(2)), "[a]\ny = 2\n\n[a.b]\nx = 1\n");
}

TEST(TomlEdit, AddAppendsAnElement) {
  EXPECT_EQ(added("a = []\n", "a", number(1)), "a = [1]\n");
  EXPECT_EQ(added("a = [1, 2] # c\n", "a", number(3)), "a = [1, 2, 3] # c\n");
  EXPECT_EQ(added("a = [\n  1, # one\n  2 # two\n]\n", "a", number(3)),
            "a = [\n  1, # one\n  2, # two\n  3\n]\n");
  EXPECT_EQ(added("a = [\n  1,\n]\n", "a", number(3)), "a = [\n  1,\n  3,\n]\n");
  EXPECT_EQ(added("[[c]]\nx = 1\n# of t\n[t]\n", "c", {Table{{"x", number(2)}}}),
            "[[c]]\nx = 1\n\n[[c]]\nx = 2\n# of t\n[t]\n");
  EXPECT_EQ(added("x = 1\n", "c", {Table{{"p", text("A")}}}), "x = 1\n\n[[c]]\np = \"A\"\n");
  EXPECT_EQ(added("x = 1\n", "c", number(1)), "x = 1\nc = [1]\n");
}

TEST(TomlEdit, RemoveTakesTheLineOrTheElement) {
  EXPECT_EQ(removed("# head\na = 1 # of a\nb = 2\n", "a"), "# head\nb = 2\n");
  EXPECT_EQ(removed("p = { a = 1, b = 2, c = 3 }\n", "p.b"), "p = { a = 1, c = 3 }\n");
  EXPECT_EQ(removed("p = { a = 1, b = 2 }\n", "p.b"), "p = { a = 1 }\n");
  EXPECT_EQ(removed("a = [1, 2, 3]\n", "a[2]"), "a = [1, 2]\n");
  EXPECT_EQ(removed("a = [1, 2, 3]\n", "a[0]"), "a = [2, 3]\n");
  EXPECT_EQ(removed("a = [\n  1, # one\n  2, # two\n]\n", "a[0]"), "a = [\n  2, # two\n]\n");
  EXPECT_EQ(removed("[[c]]\nx = 1\n# in it\ny = 2\n\n# of the next\n[[c]]\nx = 3\n", "c[0]"),
            "\n# of the next\n[[c]]\nx = 3\n");
  EXPECT_EQ(removed("[a]\nx = 1\n[b]\ny = 1\n[a.c]\nz = 1\n", "a"), "[b]\ny = 1\n");
}

TEST(TomlEdit, ProblemsHaveTheirPlace) {
  EXPECT_THAT(set("a = 1\nb = [1]\n", "b[4]", number(1)), testing::HasSubstr("f:2:"));
  EXPECT_THAT(set("a = 1\n", "a.b", number(1)), testing::HasSubstr("a is a value, not a table"));
  EXPECT_THAT(removed("a = 1\n", "b"), testing::HasSubstr("b is not in this file"));
  EXPECT_THAT(set("[a]\nx = 1\n", "a", number(1)), testing::HasSubstr("is a table"));
  EXPECT_THAT(set("a = ", "a", number(1)), testing::HasSubstr("f:1:"));
}

TEST(TomlEdit, AllOperationsOrNone) {
  const std::vector<TomlOperation> operations{
      {.kind = Kind::kSet, .path = {"a"}, .value = number(2)},
      {.kind = Kind::kRemove, .path = {"none"}}};
  const TomlEdited result = edited_toml({"f", "a = 1\n"}, operations);
  EXPECT_EQ(result.text, "a = 1\n");
  EXPECT_EQ(result.problems.size(), 1U);
}

// --- random texts and operations against a model

class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  std::size_t below(std::size_t end) { return engine_() % end; }
  bool chance(int percent) { return below(100) < static_cast<std::size_t>(percent); }

 private:
  std::mt19937 engine_;
};

TomlInput random_value(Random& random, int depth) {
  switch (random.below(depth > 0 ? 6 : 4)) {
    case 0:
      return number(static_cast<std::int64_t>(random.below(1000)) - 500);
    case 1:
      return text(std::string(random.below(4), "a\"\\\n#]}"[random.below(7)]));
    case 2:
      return {.value = random.chance(50)};
    case 3:
      return {.value = static_cast<double>(random.below(100)) / 8};
    case 4: {
      List list;
      for (std::size_t n = random.below(4); n > 0; --n)
        list.push_back(random_value(random, depth - 1));
      return {.value = list};
    }
    default: {
      Table table;
      for (std::size_t n = random.below(4); n > 0; --n)
        table.emplace_back("k" + std::to_string(n), random_value(random, depth - 1));
      return {.value = table};
    }
  }
}

// A text in one of many styles, and what it means.
class RandomText {
 public:
  explicit RandomText(Random& random) : random_(random) {
    end_ = random_.chance(20) ? "\r\n" : "\n";
    if (random_.chance(10)) text_ = "\xEF\xBB\xBF";
    keys(model_, "r");
    for (std::size_t n = random_.below(3); n > 0; --n) section("t" + std::to_string(n));
    for (std::size_t n = random_.below(4); n > 0; --n) item();
    if (!items_.empty()) model_.emplace_back("item", TomlInput{items_});
    if (random_.chance(20) && text_.ends_with(end_)) text_.resize(text_.size() - end_.size());
  }
  std::string text_;
  Table model_;

 private:
  void line(const std::string& what) {
    if (random_.chance(20)) text_ += "# comment " + std::to_string(++comments_) + end_;
    if (random_.chance(10)) text_ += end_;
    text_ += (random_.chance(10) ? "  " : "") + what;
    if (random_.chance(30)) text_ += "  # comment " + std::to_string(++comments_);
    text_ += end_;
  }
  std::string written(const TomlInput& value) {
    const auto* list = std::get_if<List>(&value.value);
    if (list == nullptr || list->empty() || random_.chance(60)) return value.to_toml();
    std::string made = "[" + end_;
    for (std::size_t i = 0; i < list->size(); ++i) {
      made += "  " + (*list)[i].to_toml();
      if (i + 1 < list->size() || random_.chance(50)) made += ",";
      if (random_.chance(40)) made += " # comment " + std::to_string(++comments_);
      made += end_;
    }
    return made + "]";
  }
  void keys(Table& table, const std::string& prefix) {
    for (std::size_t n = random_.below(4); n > 0; --n) {
      const std::string key = prefix + std::to_string(n);
      if (random_.chance(20)) {
        const TomlInput a = random_value(random_, 0);
        const TomlInput b = random_value(random_, 0);
        line(key + ".a = " + a.to_toml());
        line(key + " . b=" + b.to_toml());
        table.emplace_back(key, TomlInput{Table{{"a", a}, {"b", b}}});
        continue;
      }
      const TomlInput value = random_value(random_, 2);
      line((random_.chance(20) ? "\"" + key + "\"" : key) + (random_.chance(30) ? "=" : " = ") +
           written(value));
      table.emplace_back(key, value);
    }
  }
  void section(const std::string& name) {
    Table table;
    const bool implicit = random_.chance(30);
    if (!implicit) {
      line("[" + name + "]");
      keys(table, "s");
    }
    if (implicit || random_.chance(30)) {
      Table inner;
      line("[ " + name + ".sub ]");
      keys(inner, "u");
      table.emplace_back("sub", TomlInput{inner});
    }
    model_.emplace_back(name, TomlInput{table});
  }
  void item() {
    Table table;
    line("[[item]]");
    keys(table, "i");
    if (random_.chance(30)) {
      Table inner;
      line("[item.sub]");
      keys(inner, "u");
      table.emplace_back("sub", TomlInput{inner});
    }
    items_.push_back({.value = table});
  }

  Random& random_;
  std::string end_;
  List items_;
  int comments_ = 0;
};

bool equal(const TomlInput& model, const TomlNode& node) {
  if (const auto* table = std::get_if<Table>(&model.value)) {
    if (node.form != TomlNode::Form::kTable || node.children.size() != table->size()) return false;
    return std::ranges::all_of(*table, [&](const auto& row) {
      const auto child = std::ranges::find(node.children, row.first, &TomlNode::key);
      return child != node.children.end() && equal(row.second, *child);
    });
  }
  if (const auto* list = std::get_if<List>(&model.value))
    return node.form == TomlNode::Form::kArray &&
           std::ranges::equal(*list, node.children,
                              [](const auto& a, const auto& b) { return equal(a, b); });
  if (const auto* value = std::get_if<std::string>(&model.value))
    return std::holds_alternative<std::string>(node.value) &&
           std::get<std::string>(node.value) == *value;
  if (const auto* value = std::get_if<bool>(&model.value))
    return std::holds_alternative<bool>(node.value) && std::get<bool>(node.value) == *value;
  if (const auto* value = std::get_if<double>(&model.value))
    return std::holds_alternative<double>(node.value) && std::get<double>(node.value) == *value;
  return std::holds_alternative<std::int64_t>(node.value) &&
         std::get<std::int64_t>(node.value) == std::get<std::int64_t>(model.value);
}

// All paths of a model.
void append_paths(const TomlInput& model, const TomlPath& path, std::vector<TomlPath>& all) {
  if (!path.empty()) all.push_back(path);
  const auto under = [&](TomlStep step, const TomlInput& value) {
    TomlPath inner = path;
    inner.push_back(std::move(step));
    append_paths(value, inner, all);
  };
  if (const auto* table = std::get_if<Table>(&model.value))
    for (const auto& [key, value] : *table) under(key, value);
  if (const auto* list = std::get_if<List>(&model.value))
    for (std::size_t i = 0; i < list->size(); ++i) under(i, (*list)[i]);
}

TomlInput& at(TomlInput& model, std::span<const TomlStep> path) {
  TomlInput* node = &model;
  for (const TomlStep& step : path) {
    if (const auto* index = std::get_if<std::size_t>(&step)) {
      node = &std::get<List>(node->value)[*index];
    } else {
      auto& table = std::get<Table>(node->value);
      node =
          &std::ranges::find(table, std::get<std::string>(step), &Table::value_type::first)->second;
    }
  }
  return *node;
}

void apply(TomlInput& model, const TomlOperation& operation) {
  const std::span all(operation.path);
  if (operation.kind == Kind::kAdd) {
    std::get<List>(at(model, all).value).push_back(operation.value);
    return;
  }
  TomlInput& owner = at(model, all.first(all.size() - 1));
  if (const auto* index = std::get_if<std::size_t>(&all.back())) {
    List& list = std::get<List>(owner.value);
    if (operation.kind == Kind::kSet)
      list[*index] = operation.value;
    else
      list.erase(list.begin() + static_cast<std::ptrdiff_t>(*index));
    return;
  }
  Table& table = std::get<Table>(owner.value);
  const auto& key = std::get<std::string>(all.back());
  std::erase_if(table, [&](const auto& row) { return row.first == key; });
  if (operation.kind == Kind::kSet) table.emplace_back(key, operation.value);
}

// A table or list without content is not in a text that only had it as a heading.
void drop_empty(TomlInput& model) {
  if (auto* table = std::get_if<Table>(&model.value)) {
    for (auto& row : *table) drop_empty(row.second);
    std::erase_if(*table, [](const auto& row) {
      const auto* inner = std::get_if<Table>(&row.second.value);
      const auto* list = std::get_if<List>(&row.second.value);
      return (inner != nullptr && inner->empty()) || (list != nullptr && list->empty());
    });
  }
}
TomlInput model_of(const TomlNode& node) {
  if (node.form == TomlNode::Form::kTable) {
    Table table;
    for (const TomlNode& child : node.children) table.emplace_back(child.key, model_of(child));
    return {.value = table};
  }
  if (node.form == TomlNode::Form::kArray) {
    List list;
    for (const TomlNode& child : node.children) list.push_back(model_of(child));
    return {.value = list};
  }
  if (const auto* value = std::get_if<std::string>(&node.value)) return {.value = *value};
  if (const auto* value = std::get_if<bool>(&node.value)) return {.value = *value};
  if (const auto* value = std::get_if<double>(&node.value)) return {.value = *value};
  return {.value = std::get<std::int64_t>(node.value)};
}
bool same_content(TomlInput expected, const TomlNode& root) {
  TomlInput found = model_of(root);
  drop_empty(expected);
  drop_empty(found);
  const TomlTree again = parse_toml({"m", [&] {
                                       std::string made;
                                       for (const auto& [key, value] : std::get<Table>(found.value))
                                         made += in_quotes(key) + " = " + value.to_toml() + "\n";
                                       return made;
                                     }()});
  return again.problems.empty() && equal(expected, again.root);
}

std::vector<std::string> lines_of(const std::string& all) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < all.size();) {
    const std::size_t end = std::min(all.find('\n', at), all.size() - 1) + 1;
    lines.push_back(all.substr(at, end - at));
    at = end;
  }
  return lines;
}

// The lines in which two texts differ lie in one block.
std::pair<std::size_t, std::size_t> changed_block(const std::string& a, const std::string& b) {
  const auto x = lines_of(a);
  const auto y = lines_of(b);
  std::size_t head = 0;
  while (head < x.size() && head < y.size() && x[head] == y[head]) ++head;
  std::size_t tail = 0;
  while (tail < x.size() - head && tail < y.size() - head &&
         x[x.size() - 1 - tail] == y[y.size() - 1 - tail])
    ++tail;
  return {x.size() - head - tail, y.size() - head - tail};
}

std::vector<std::string> comments_in(const std::string& all) {
  std::vector<std::string> comments;
  for (const std::string& line : lines_of(all))
    if (const std::size_t at = line.find("# comment"); at != std::string::npos)
      comments.emplace_back(trimmed(std::string_view(line).substr(at), "\r\n"));
  return comments;
}

TEST(TomlEdit, RandomTextsAndOperationsMeanWhatTheModelMeans) {
  std::size_t done = 0;
  std::size_t refused = 0;
  for (std::uint32_t seed = 0; seed < 6000; ++seed) {
    Random random(seed);
    RandomText made(random);
    TomlInput model{made.model_};
    const TomlTree before = parse_toml({"f", made.text_});
    ASSERT_TRUE(before.problems.empty()) << made.text_ << before.problems.front().text;
    ASSERT_TRUE(equal(model, before.root)) << made.text_;
    std::vector<TomlPath> paths;
    append_paths(model, {}, paths);
    if (paths.empty()) continue;
    TomlOperation operation{.kind = static_cast<Kind>(random.below(3)),
                            .path = paths[random.below(paths.size())],
                            .value = random_value(random, 1)};
    const TomlInput& target = at(model, operation.path);
    const bool is_list = std::holds_alternative<List>(target.value);
    if (operation.kind == Kind::kAdd && !is_list) continue;
    if (operation.kind == Kind::kSet && random.chance(40) &&
        std::holds_alternative<Table>(target.value))
      operation.path.emplace_back("fresh");
    const TomlEdited result = edited_toml({"f", made.text_}, {&operation, 1});
    if (!result.problems.empty()) {
      EXPECT_EQ(result.text, made.text_);
      ++refused;
      // Only whole tables are refused.
      const bool whole = std::holds_alternative<Table>(target.value) || is_list;
      EXPECT_TRUE(whole) << made.text_ << to_string(operation.path)
                         << result.problems.front().to_string();
      continue;
    }
    ++done;
    const bool one_line =
        operation.kind != Kind::kRemove && std::holds_alternative<std::int64_t>(target.value);
    apply(model, operation);
    const TomlTree after = parse_toml({"f", result.text});
    ASSERT_TRUE(after.problems.empty()) << result.text;
    ASSERT_TRUE(same_content(model, after.root))
        << "seed " << seed << " " << to_string(operation.path) << "\n"
        << made.text_ << "---\n"
        << result.text;
    if (operation.kind == Kind::kAdd) {
      EXPECT_EQ(comments_in(result.text), comments_in(made.text_)) << result.text;
    }
    if (one_line) {  // all others are equal, byte for byte
      const auto [gone, come] = changed_block(made.text_, result.text);
      EXPECT_LE(gone, 1U) << made.text_ << "---\n" << result.text;
      EXPECT_LE(come, gone);
    }
  }
  EXPECT_GT(done, 3000U);
  EXPECT_LT(refused, done / 5);
}

}  // namespace toml_edit_test
}  // namespace tims::base
