#include "router/config/toml_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tims::config {
namespace {

std::string place(const Origin& at) {
  return std::to_string(at.line) + ":" + std::to_string(at.column);
}

std::vector<std::string> keys(const TomlText& text) {
  std::vector<std::string> list;
  list.reserve(text.assignments.size());
  for (const Assignment& a : text.assignments) list.push_back(a.key);
  return list;
}

TEST(TomlSource, AssignmentsComeInTheOrderOfTheText) {
  const TomlText text = parse_toml({"f", "z = 1\n[tcp]\nqueue = 2\nlisten = \"x\"\n[log]\n"});
  EXPECT_THAT(keys(text), testing::ElementsAre("z", "tcp", "tcp.queue", "tcp.listen", "log"));
  EXPECT_TRUE(text.assignments[1].table);
  EXPECT_FALSE(text.assignments[2].table);
}

TEST(TomlSource, KnowsWhereKeysAndValuesStand) {
  const TomlText text = parse_toml({"f", "[tcp]\n  queue =  \"4MiB\"\n"});
  ASSERT_EQ(text.assignments.size(), 2U);
  EXPECT_EQ(place(text.assignments[1].at_key), "2:3");
  EXPECT_EQ(place(text.assignments[1].at_value), "2:12");
  EXPECT_EQ(text.assignments[1].at_key.file, "f");
}

TEST(TomlSource, WhatLiesDeeperIsOneForeignValue) {
  const TomlText text = parse_toml({"f", "[tcp.listen]\na = 1\nb = 2\n"});
  EXPECT_THAT(keys(text), testing::ElementsAre("tcp", "tcp.listen"));
  EXPECT_EQ(std::get<Foreign>(text.assignments[1].value).what, "a table");
}

TEST(TomlSource, ArraysOfTablesAreCounted) {
  for (const char* written : {"[[link]]\na = 1\nb = [{c = 1}]\n[[link]]\n[[link]]\na = 2\n",
                              "link = [{a = 1, b = [{c = 1}]}, {}, {a = 2}]\n"}) {
    const TomlText text = parse_toml({"f", written});
    EXPECT_THAT(keys(text),
                testing::ElementsAre("link", "link.a", "link.b", "link", "link", "link.a"));
    std::vector<std::size_t> items;
    items.reserve(text.assignments.size());
    for (const Assignment& a : text.assignments) items.push_back(a.item.value_or(99));
    EXPECT_THAT(items, testing::ElementsAre(0, 0, 0, 1, 2, 2));
    EXPECT_TRUE(text.assignments[4].table);
    EXPECT_EQ(std::get<Foreign>(text.assignments[2].value).what, "an array of tables");
  }
  EXPECT_EQ(place(parse_toml({"f", "\n[[link]]\n"}).assignments.at(0).at_key), "2:1");
}

TEST(TomlSource, NamesTheTypesNoOptionTakes) {
  const auto what = [](const std::string& value) {
    const TomlText text = parse_toml({"f", "x = " + value + "\n"});
    return std::string(std::get<Foreign>(text.assignments.at(0).value).what);
  };
  EXPECT_EQ(what("[1, 2]"), "an array");
  EXPECT_EQ(what("[{a = 1}, 2]"), "an array");
  EXPECT_EQ(what("07:32:00"), "a date or time");
}

TEST(TomlSource, ReadsFractions) {
  const TomlText text = parse_toml({"f", "x = -1.5\n"});
  EXPECT_EQ(std::get<double>(text.assignments.at(0).value), -1.5);
}

TEST(TomlSource, ATextThatIsNotTomlGivesNothingButItsProblem) {
  const TomlText text = parse_toml({"f", "a = 1\nb = \n"});
  EXPECT_TRUE(text.assignments.empty());
  ASSERT_EQ(text.problems.size(), 1U);
  EXPECT_EQ(text.problems[0].at.line, 2U);
}

TEST(TomlTree, IsNestedAsTheTextAndInItsOrder) {
  const TomlTree tree = parse_toml_tree(
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
  const TomlNode& hosts = robots.children.at(0).children.at(0);
  EXPECT_EQ(std::get<std::string>(hosts.children.at(1).value), "a");
  EXPECT_EQ(place(hosts.children.at(1).at_key), "5:15");
}

TEST(TomlTree, SaysWhereTheTextIsNoToml) {
  const TomlTree tree = parse_toml_tree({"f", "a = 1\nb = \n"});
  ASSERT_EQ(tree.problems.size(), 1U);
  EXPECT_EQ(tree.problems[0].at.line, 2U);
  EXPECT_TRUE(tree.root.children.empty());
}

TEST(TomlTree, GoesSixteenDeep) {
  const TomlTree tree =
      parse_toml_tree({"f", "a = " + std::string(40, '[') + std::string(40, ']') + "\n"});
  int depth = 0;
  for (const TomlNode* at = &tree.root; !at->children.empty(); at = at->children.data()) ++depth;
  EXPECT_LE(depth, 18);
}

}  // namespace
}  // namespace tims::config
