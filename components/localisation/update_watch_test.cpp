#include "components/localisation/update_watch.h"

#include <gtest/gtest.h>

namespace rack::localisation {
namespace update_watch_test {

TEST(UpdateWatch, TheMovementOfTheOdometryIsNoUpdate) {
  UpdateWatch watch;
  Pose odometry{.x = 50, .y = -20, .rho = 1};
  Pose position{.x = 7000, .y = 300, .rho = 4};
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(watch.is_updated(position, odometry)) << i;
    const Pose step{.x = 300, .y = 10, .rho = 0.3};
    odometry = odometry + step;
    position = position + step;
  }
}

TEST(UpdateWatch, AJumpIsReportedOnce) {
  UpdateWatch watch;
  EXPECT_FALSE(watch.is_updated({}, {}));
  EXPECT_FALSE(watch.is_updated({.x = UpdateWatch::kJump}, {}));
  EXPECT_TRUE(watch.is_updated({.x = 2 * UpdateWatch::kJump + 1}, {}));
  EXPECT_FALSE(watch.is_updated({.x = 2 * UpdateWatch::kJump + 1}, {}));
}

TEST(UpdateWatch, OwnUpdatesAreNotOthers) {
  UpdateWatch watch;
  EXPECT_FALSE(watch.is_updated({}, {}));
  watch.on_own_update({.x = 5000}, {});
  EXPECT_FALSE(watch.is_updated({.x = 5000}, {}));
}

}  // namespace update_watch_test
}  // namespace rack::localisation
