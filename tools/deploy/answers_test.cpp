#include "tools/deploy/answers.h"

#include <gmock/gmock.h>

namespace timsctl::deploy {
namespace answers_test {

using testing::ElementsAre;
using testing::IsEmpty;

const std::string kDigest(64, '0');
const std::string kOther(64, 'a');

TEST(DeployAnswers, WhatIsThere) {
  const Facts facts = facts_of(
      "arch amd64\npackage timsctl 0.2.0 ii \npackage tims-router 0.1 rc \n" +
      ("file router.toml " + kDigest + " 6162\n") + ("file keys/identity.key " + kOther + " -\n") +
      ("deployed " + kOther + "  router.toml\n") +
      ("deb " + kOther + "  timsctl_0.2.0_amd64.deb\n") + "undo\nend\n");
  EXPECT_TRUE(facts.complete);
  EXPECT_TRUE(facts.can_undo);
  EXPECT_FALSE(facts.interrupted);
  EXPECT_EQ(facts.architecture, "amd64");
  EXPECT_THAT(facts.packages, ElementsAre(std::pair("timsctl", "0.2.0")));
  ASSERT_EQ(facts.files.size(), 2U);
  EXPECT_EQ(facts.files.at("router.toml").text, "ab");
  EXPECT_EQ(facts.files.at("keys/identity.key").text, std::nullopt);
  EXPECT_EQ(facts.deployed.at("router.toml"), kOther);
  EXPECT_EQ(facts.debs.at("timsctl_0.2.0_amd64.deb"), kOther);
  EXPECT_TRUE(facts_of("phase applying\n").interrupted);
}

TEST(DeployAnswers, AnAnswerThatWasCutOrIsNone) {
  EXPECT_FALSE(facts_of("arch amd64\n").complete);
  EXPECT_FALSE(facts_of("").complete);
  const Facts facts =
      facts_of("Last login: today\nfile ../passwd " + kDigest + " 00\nfile router.toml x 00\n" +
               "deb " + kDigest + "\nfile\npackage\n\0\xFF\nend");
  EXPECT_THAT(facts.files, IsEmpty());
  EXPECT_THAT(facts.debs, IsEmpty());
  EXPECT_THAT(facts.packages, IsEmpty());
}

TEST(DeployAnswers, WhatAptWillDo) {
  EXPECT_THAT(changes_of("install tims-router - 0.2.0\ninstall timsctl 0.1 0.2.0\ninstall x 1 -\n"
                         "install bad\nInst no 1 2\n"),
              ElementsAre(PackageChange{"tims-router", "", "0.2.0"},
                          PackageChange{"timsctl", "0.1", "0.2.0"}, PackageChange{"x", "1", ""}));
}

TEST(DeployAnswers, HowAJobGoesAndEnds) {
  const Progress progress =
      progress_of("step installing\nstep checking\nresult back doctor: x\x1B[2J\nlog a\nlog b\n");
  EXPECT_THAT(progress.steps, ElementsAre("installing", "checking"));
  EXPECT_THAT(progress.log, ElementsAre("a", "b"));
  EXPECT_EQ(progress.end, End::kWentBack);
  EXPECT_EQ(progress.reason, "doctor: x?[2J");
  EXPECT_EQ(progress_of("result kept\n").end, End::kKept);
  EXPECT_EQ(progress_of("result same\n").end, End::kSame);
  EXPECT_EQ(progress_of("result broken x\n").end, End::kBroken);
  EXPECT_EQ(progress_of("result fine\n").end, End::kNone);
}

TEST(DeployAnswers, TheReasonOfAFailure) {
  EXPECT_EQ(reason_in("motd\ntims-deploy: disk: full\nbye\n"), "disk: full");
  EXPECT_EQ(reason_in("ssh: connect to host arm port 22: No route to host\r\n\n"),
            "ssh: connect to host arm port 22: No route to host");
  EXPECT_EQ(reason_in(""), "");
}

TEST(DeployAnswers, NamesThatAreDeployed) {
  for (const char* name : {"router.toml", "router.d/10-rules.toml", "robots/scout.toml",
                           "robots/floor.dxf", "keys/identity.key"})
    EXPECT_TRUE(is_deployed_name(name)) << name;
  const std::string longest = "robots/" + std::string(64, 'a');
  EXPECT_TRUE(is_deployed_name(longest));
  EXPECT_FALSE(is_deployed_name(longest + "a"));
  for (const char* name : {"", "/etc/passwd", "../router.toml", "robots/", "robots/.x", "robots/-x",
                           "robots/a/b", "keys/authority/root.key", "router.tomll", "other/x",
                           "robots/a b", "robots/a'b", "robots/$x"})
    EXPECT_FALSE(is_deployed_name(name)) << name;
}

}  // namespace answers_test
}  // namespace timsctl::deploy
