#include "security/keys/identity.h"

#include <gtest/gtest.h>

namespace tims::security::identity_test {

Result<Identity> parse(const std::vector<std::string>& uris) { return Identity::parse(uris); }

TEST(Identity, OfRoutersAndUsers) {
  const auto robot = parse({"tims://harbour/system/3/1", "tims://harbour/name/robot3"}).value();
  EXPECT_EQ(robot, (Identity{.fleet = "harbour",
                             .role = MemberRole::kSystem,
                             .system = 3,
                             .id = 1,
                             .name = "robot3",
                             .rights = {}}));
  EXPECT_EQ(robot.to_string(), "system 3, id 1 (robot3)");
  EXPECT_EQ(parse(robot.uris()).value(), robot);
  EXPECT_EQ(parse({"tims://f/top/0/1"}).value().name, "base");
  EXPECT_EQ(parse({"tims://f/system/65535/65535"}).value().system, 65535);
  EXPECT_EQ(parse({"tims://f/subsystem/3/2"}).value().name, "robot3-2");
  const auto anna = parse({"tims://f/right/drive", "tims://f/user/anna"}).value();
  EXPECT_EQ(anna.rights, (Rights{.look = false, .drive = true, .configure = false}));
  EXPECT_EQ(parse(anna.uris()).value(), anna);
}

TEST(Identity, WhatIsNotExactlyOneIdentityIsRefused) {
  const std::string nul = "tims://f/system/3/1" + std::string(1, '\0');
  for (const std::vector<std::string>& uris : std::vector<std::vector<std::string>>{
           {},
           {"tims://f/name/robot3"},
           {"tims://f/system/3/1", "tims://f/system/3/2"},
           {"tims://f/system/3/1", "tims://f/system/3/1"},
           {"tims://f/system/3/1", "tims://f/user/anna"},
           {"tims://f/system/3/1", "tims://g/name/robot3"},
           {"tims://f/system/3/1", "tims://f/right/drive"},
           {"tims://f/system/3/1", "tims://f/name/a", "tims://f/name/b"},
           {"tims://f/user/anna", "tims://f/name/robot3"},
           {"tims://f/user/anna", "tims://f/right/look", "tims://f/right/look"},
           {"tims://f/system/3/1", "https://f/"},
           {nul},
           {"tims://f" + std::string(1, '\0') + "/system/3/1"},
           {"TIMS://f/system/3/1"},
           {"tims://f/System/3/1"},
           {"tims://f/system/3/1/"},
           {"tims://f/system/3/1/2"},
           {"tims://f/system//1"},
           {"tims://f/system/03/1"},
           {"tims://f/system/+3/1"},
           {"tims://f/system/-3/1"},
           {"tims://f/system/ 3/1"},
           {"tims://f/system/65536/1"},
           {"tims://f/system/3"},
           {"tims://f/user/3/1"},
           {"tims:///system/3/1"},
           {"tims://f/right/all"},
           {"tims://f/user/"},
           {"tims://f"},
           {"tims://"}}) {
    EXPECT_FALSE(parse(uris).ok()) << (uris.empty() ? "" : uris.front());
  }
}

TEST(Identity, NamesHaveAnEndAndNoStrangeCharacters) {
  EXPECT_TRUE(is_name("a"));
  EXPECT_TRUE(is_name("harbour-2.west_A"));
  EXPECT_TRUE(is_name(std::string(63, 'a')));
  EXPECT_FALSE(is_name(std::string(64, 'a')));
  for (const std::string_view text : {"", "-a", "a-", ".", "a b", "a/b", "ä", "a\n", "a*"})
    EXPECT_FALSE(is_name(text)) << text;
}

}  // namespace tims::security::identity_test
