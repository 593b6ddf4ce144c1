#include "components/runtime/robot_run.h"

#include <cstdlib>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace rack {
namespace robot_run_test {

TEST(FirstOfRobot, OnceForEachRemarkAndRun) {
  const tims::test::TemporaryFolder folder;
  ::setenv("RACK_RUN", folder.path().c_str(), 1);
  EXPECT_TRUE(first_of_robot("real-time"));
  EXPECT_FALSE(first_of_robot("real-time"));
  EXPECT_TRUE(first_of_robot("memory"));
  ::setenv("RACK_RUN", "/nowhere", 1);
  EXPECT_TRUE(first_of_robot("real-time")) << "better twice than never";
  EXPECT_TRUE(first_of_robot("real-time"));
  ::unsetenv("RACK_RUN");
  EXPECT_TRUE(first_of_robot("real-time"));
}

}  // namespace robot_run_test
}  // namespace rack
