#include "router/config/toml_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tims::config {
namespace {

std::string place(const Origin& at) {
  return std::to_string(at.line) + ":" + std::to_string(at.column);
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
