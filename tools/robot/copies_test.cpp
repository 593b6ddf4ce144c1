#include "tools/robot/copies.h"

#include <gtest/gtest.h>

namespace timsctl::robot {
namespace copies_test {

TEST(ComponentOf, ItsProgramSystemAndInstance) {
  EXPECT_EQ(component_of({"ChassisSim", "--system=3", "--instance=1", "--vxMax=900"}),
            "ChassisSim, system 3, instance 1");
  EXPECT_EQ(component_of({"nice", "-n", "-15", "/opt/bin/World", "--file=x", "--system=3"}),
            "World, system 3, instance 0");
}

TEST(ComponentOf, OtherCommandsHaveNone) {
  EXPECT_EQ(component_of({}), std::nullopt);
  EXPECT_EQ(component_of({"sh", "late.sh"}), std::nullopt);
  EXPECT_EQ(component_of({"tool", "--all"}), std::nullopt);
  EXPECT_EQ(component_of({"--system=3"}), std::nullopt);
  EXPECT_EQ(component_of({"ssh", "-oBatchMode=yes", "--", "arm", "--system=3"}), std::nullopt);
}

}  // namespace copies_test
}  // namespace timsctl::robot
