#include "tools/sim/host_files.h"

#include <gtest/gtest.h>

#include "tools/cli/failure.h"

namespace timsctl::sim {
namespace host_files_test {

TEST(HostFiles, ARobotGetsItsSystemAndKeepsEverythingElse) {
  const std::string rest =
      "# Which one?\nname = \"scout\"   # this one\n\n[[component]]\nprogram = \"Gps\"\n";
  const std::string made = with_system({"scout.toml", rest}, 7);
  EXPECT_NE(made.find("system = 7\n"), std::string::npos) << made;
  EXPECT_LT(made.find("system = 7"), made.find("[[component]]"));
  std::string without = made;
  without.erase(without.find("system = 7\n"), std::string("system = 7\n").size());
  EXPECT_EQ(without, rest);
}

TEST(HostFiles, ASystemInTheFileIsReplaced) {
  EXPECT_EQ(with_system({"scout.toml", "system = 3   # of the yard\n"}, 250),
            "system = 250   # of the yard\n");
}

TEST(HostFiles, WhatIsNoTomlIsRefusedWithItsPlace) {
  try {
    (void)with_system({"../robots/scout.toml", "name = \n"}, 1);
    FAIL();
  } catch (const Failure& failure) {
    EXPECT_NE(failure.message.find("../robots/scout.toml:1"), std::string::npos) << failure.message;
  }
}

}  // namespace host_files_test
}  // namespace timsctl::sim
