#include "base/toml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tims::base {
namespace toml_test {

using namespace std::chrono_literals;
using testing::ElementsAre;

std::string place(const Place& at) {
  return std::to_string(at.line) + ":" + std::to_string(at.column);
}

TomlNode first_of(const std::string& text) {
  const TomlTree tree = parse_toml({"f", text});
  EXPECT_TRUE(tree.problems.empty());
  return tree.root.children.at(0);
}

TEST(TomlTree, IsNestedAsTheTextAndInItsOrder) {
  const TomlTree tree = parse_toml(
      {"f", "name = \"x\"\n[profile.wifi]\nloss = \"1%\"\n[[robot]]\nhosts = [\"b\", \"a\"]\n"});
  EXPECT_TRUE(tree.problems.empty());
  ASSERT_EQ(tree.root.children.size(), 3U);
  EXPECT_EQ(std::get<std::string>(tree.root.children[0].value), "x");
  const TomlNode& wifi = tree.root.children[1].children.at(0);
  EXPECT_EQ(wifi.key, "wifi");
  EXPECT_EQ(wifi.form, TomlNode::Form::kTable);
  EXPECT_EQ(place(wifi.children.at(0).at_value), "3:8");
  const TomlNode& robots = tree.root.children[2];
  EXPECT_EQ(robots.form, TomlNode::Form::kArray);
  EXPECT_TRUE(robots.is_array_of_tables());
  const TomlNode& hosts = robots.children.at(0).children.at(0);
  EXPECT_FALSE(hosts.is_array_of_tables());
  EXPECT_THAT(std::get<std::vector<std::string>>(hosts.value), ElementsAre("b", "a"));
  EXPECT_EQ(std::get<std::string>(hosts.children.at(1).value), "a");
  EXPECT_EQ(place(hosts.children.at(1).at_key), "5:15");
}

TEST(TomlTree, NamesTheTypesNobodyTakes) {
  const auto what = [](const std::string& value) {
    return std::string(std::get<Foreign>(first_of("x = " + value + "\n").value).what);
  };
  EXPECT_EQ(what("[1, 2]"), "an array");
  EXPECT_EQ(what("[{a = 1}, 2]"), "an array");
  EXPECT_EQ(what("[{a = 1}]"), "an array of tables");
  EXPECT_EQ(what("{a = 1}"), "a table");
  EXPECT_EQ(what("07:32:00"), "a date or time");
  EXPECT_EQ(std::get<double>(first_of("x = -1.5\n").value), -1.5);
}

TEST(TomlTree, ReportsWhereTheTextIsNotToml) {
  const TomlTree tree = parse_toml({"f", "a = 1\nb = \n"});
  ASSERT_EQ(tree.problems.size(), 1U);
  EXPECT_EQ(tree.problems[0].at.line, 2U);
  EXPECT_THAT(tree.problems[0].to_string(), testing::StartsWith("f:2:"));
  EXPECT_TRUE(tree.root.children.empty());
}

TEST(TomlTree, GoesSixteenDeep) {
  const TomlTree tree =
      parse_toml({"f", "a = " + std::string(40, '[') + std::string(40, ']') + "\n"});
  int depth = 0;
  for (const TomlNode* at = &tree.root; !at->children.empty(); at = at->children.data()) ++depth;
  EXPECT_LE(depth, 18);
}

// A file with one key of each kind.
struct Sample {
  std::string text;
  std::string plain;
  std::int64_t number = 0;
  double real = 0;
  Duration duration{};
  std::vector<std::string> list;
  std::vector<std::string> names;
  std::vector<std::string> problems;
};

Sample read(const std::string& text) {
  Sample out;
  TomlReader reader;
  const TomlTree tree = parse_toml({"f", text});
  reader.table(
      tree.root, "a sample",
      {{"text", [&](const TomlNode& node) { reader.text(node, out.text); }},
       {"plain", [&](const TomlNode& node) { reader.plain(node, out.plain); }},
       {"number", [&](const TomlNode& node) { reader.number(node, 1, 9, out.number); }},
       {"real", [&](const TomlNode& node) { reader.real(node, -1.5, 9, out.real); }},
       {"duration", [&](const TomlNode& node) { reader.duration(node, false, out.duration); }},
       {"list",
        [&](const TomlNode& node) {
          reader.texts(node,
                       [&](const TomlNode&, const std::string& each) { out.list.push_back(each); });
        }},
       {"item",
        [&](const TomlNode& node) {
          reader.tables(node, [&](const TomlNode&) { out.names.emplace_back("item"); });
        }},
       {"named", [&](const TomlNode& node) {
          reader.named_tables(node, [&](const TomlNode& each) { out.names.push_back(each.key); });
        }}});
  for (const Problem& problem : reader.problems()) out.problems.push_back(problem.to_string());
  return out;
}

TEST(TomlReader, EveryKeyGoesToItsFunction) {
  const Sample sample = read(
      "text = \"x\"\nplain = true\nnumber = 3\nduration = \"5s\"\nlist = [\"a\", \"b\"]\n"
      "[[item]]\n[named.n1]\n[named.n2]\n");
  EXPECT_THAT(sample.problems, ElementsAre());
  EXPECT_EQ(sample.text, "x");
  EXPECT_EQ(sample.plain, "1");
  EXPECT_EQ(sample.number, 3);
  EXPECT_EQ(sample.duration, 5s);
  EXPECT_THAT(sample.list, ElementsAre("a", "b"));
  EXPECT_THAT(sample.names, ElementsAre("item", "n1", "n2"));
  EXPECT_EQ(read("plain = 1.5\n").plain, "1.5");
  EXPECT_EQ(read("plain = \"t\"\n").plain, "t");
}

TEST(TomlReader, RealNumbersAreWholeOnesToo) {
  EXPECT_EQ(read("real = -1.5\n").real, -1.5);
  EXPECT_EQ(read("real = 9\n").real, 9);
  for (const char* wrong : {"-1.6", "9.1", "10", "nan", "inf", "true"}) {
    const Sample sample = read(std::string("real = ") + wrong + "\n");
    EXPECT_THAT(
        sample.problems,
        ElementsAre(std::string("f:1:8: real must be a number from -1.5 to ") + "9, not " + wrong));
  }
  EXPECT_THAT(read("real = [1]\n").problems,
              ElementsAre("f:1:8: real must be a number from -1.5 to 9, not an array"));
}

TEST(TomlReader, EveryProblemHasItsPlace) {
  const Sample sample = read(
      "text = 1\nplain = []\nnumber = 10\nduration = \"0s\"\nlist = [1]\nitem = 1\nnamed = 2\n"
      "txet = 1\ncolour = 1\n");
  EXPECT_THAT(
      sample.problems,
      ElementsAre("f:1:8: text must be a text in quotes, not 1",
                  "f:2:9: plain must be a number, a text, true or false, not an array",
                  "f:3:10: number must be a number from 1 to 9, not 10",
                  "f:4:12: duration must be a duration such as \"5s\", not \"0s\"",
                  "f:5:9: list must contain texts in quotes, not 1",
                  "f:6:8: item must be [[item]] above the keys of each, not 1",
                  "f:7:9: named must be [named.NAME] above the keys of each, not 2",
                  "f:8:1: unknown key of a sample \"txet\"; did you mean text?",
                  "f:9:1: unknown key of a sample \"colour\"; there are text, plain, number, real, "
                  "duration, list, item, named"));
}

}  // namespace toml_test
}  // namespace tims::base
