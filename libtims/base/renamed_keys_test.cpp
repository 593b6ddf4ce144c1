#include "base/renamed_keys.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tims::base {
namespace renamed_keys_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string migrated_text(const std::string& text) {
  const TomlEdited edited = migrated({"f.toml", text});
  return edited.problems.empty() ? edited.text : edited.problems.front().to_string();
}

TEST(RenamedKeys, AreValidPathsToAnotherName) {
  EXPECT_THAT(renamed_keys(), testing::Not(IsEmpty()));
  for (const RenamedKey& row : renamed_keys()) {
    std::string path(row.path);
    for (std::size_t at = 0; (at = path.find("[]", at)) != std::string::npos;)
      path.replace(at, 2, "[0]");
    const auto parsed = parse_toml_path(path);
    ASSERT_TRUE(parsed) << row.path;
    EXPECT_NE(std::get<std::string>(parsed->back()), row.name);
    EXPECT_THAT(std::string(row.since), testing::MatchesRegex("[0-9]+\\.[0-9]+"));
  }
}

TEST(RenamedKeys, AllFormsOfAKeyAreRewrittenAndNothingElse) {
  EXPECT_EQ(
      migrated_text("# r\n[[component]]\r\nprogram = \"Scan2d\"\n"
                    "parameters = { a=1,  reflectorFilter =1 , b = 2 } # c\n"
                    "[[component]]\nprogram = '/opt/Scan2d'\nparameters.reflectorFilter = 0# d\n"
                    "[[component]]\nprogram = \"Scan2d\"\n[component.parameters]\n"
                    "  \"reflectorFilter\"   = 1\n"),
      "# r\n[[component]]\r\nprogram = \"Scan2d\"\n"
      "parameters = { a=1,  reflectorFilterMode =1 , b = 2 } # c\n"
      "[[component]]\nprogram = '/opt/Scan2d'\nparameters.reflectorFilterMode = 0# d\n"
      "[[component]]\nprogram = \"Scan2d\"\n[component.parameters]\n"
      "  reflectorFilterMode   = 1\n");
  EXPECT_EQ(migrated_text("robot = [{ slip = { way = 0.1, way_noise = 2 } }]"),
            "robot = [{ slip = { distance = 0.1, distance_noise = 2 } }]");
  EXPECT_EQ(migrated_text("robot = [{ slip = { way = 0.1 } }, { slip.way = 1 }]"),
            "robot = [{ slip = { distance = 0.1 } }, { slip.distance = 1 }]");
}

TEST(RenamedKeys, OthersOfTheSameNameStay) {
  for (const std::string text :
       {"", "[[component]]\nprogram = \"Mine\"\nparameters = { reflectorFilter = 1 }\n",
        "[[component]]\ncommand = \"Scan2d\"\nparameters = { reflectorFilter = 1 }\n",
        "[component]\nprogram = \"Scan2d\"\nparameters = { reflectorFilter = 1 }\n",
        "component = [1, 2]\nrobot = 1\n[slip]\nway = 1\n",
        "[[component]]\nprogram = 1\nparameters = 2\n[[robot]]\nslip = [1]\nway = 1\n"})
    EXPECT_EQ(migrated_text(text), text);
}

TEST(RenamedKeys, BothNamesAreRefused) {
  const std::string text = "[[robot]]\nslip = { way = 1, distance = 2 }\n";
  EXPECT_THAT(migrated_text(text), HasSubstr("is there as distance, too: remove one of them"));
  TomlTree tree = parse_toml({"f.toml", text});
  EXPECT_THAT(rename_former_keys(tree), IsEmpty());
  EXPECT_NE(find_node(tree.root, *parse_toml_path("robot[0].slip.way")), nullptr);
}

TEST(RenamedKeys, ATreeHasTheNamesOfNowAndHintsHavePlaces) {
  TomlTree tree = parse_toml({"f.toml", "[[robot]]\nslip = { turn = 1, way = 2 }\n"});
  const std::vector<FormerKey> former = former_keys(tree);
  ASSERT_EQ(former.size(), 1U);
  EXPECT_EQ(to_string(former[0].path_now()), "robot[0].slip.distance");
  EXPECT_THAT(rename_former_keys(tree),
              ElementsAre(testing::ResultOf(
                  [](const Problem& hint) { return hint.to_string(); },
                  HasSubstr("f.toml:2:20: way is called distance since 0.2, and is understood"))));
  EXPECT_NE(find_node(tree.root, former[0].path_now()), nullptr);
  EXPECT_THAT(former_keys(tree), IsEmpty());
}

}  // namespace renamed_keys_test
}  // namespace tims::base
