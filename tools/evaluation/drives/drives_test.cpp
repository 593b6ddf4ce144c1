// Goal drives in simulated time: quiet, beside other busy programs, with lost data, with crashes.
// `rack-drives` runs more of them, and draws one: deploy/worlds/floor.toml,
// deploy/robots/floor.dxf.
#include <algorithm>

#include <gtest/gtest.h>

#include "tools/evaluation/drives/drive.h"
#include "tools/evaluation/drives/scene_file.h"

namespace rack::drives {
namespace drives_test {

using namespace std::chrono_literals;

Course course() {
  auto scene = read_scene(DEPLOY "/worlds/floor.toml", DEPLOY "/robots/floor.dxf");
  EXPECT_TRUE(scene) << scene.error().message();
  auto made = Course::make(std::move(*scene));
  EXPECT_TRUE(made) << made.error().message();
  return std::move(*made);
}

struct Weather {
  const char* name;
  Load load;
};
std::ostream& operator<<(std::ostream& out, const Weather& weather) { return out << weather.name; }

class Drives : public testing::TestWithParam<Weather> {};

// Nearly all arrive, or have no path; a robot that does not arrive stands and reports why.
TEST_P(Drives, Arrive) {
  constexpr std::uint64_t kDrives = 125;
  const Course floor = course();
  std::uint64_t failed = 0;
  for (std::uint64_t seed = 1; seed <= kDrives; ++seed) {
    const DriveResult result = floor.drive({.seed = seed, .load = GetParam().load});
    EXPECT_EQ(result.contacts, 0U) << seed;
    EXPECT_FALSE(result.was_certain_of_a_wrong_place()) << seed;
    if (result.outcome == Outcome::kArrived) {
      EXPECT_LT(result.off_goal, 300) << seed;
    } else {
      EXPECT_FALSE(result.why.empty()) << seed;
    }
    if (result.outcome == Outcome::kGaveUp) ++failed;
  }
  EXPECT_LE(failed, 3U);
}

INSTANTIATE_TEST_SUITE_P(
    Floor, Drives,
    testing::Values(Weather{"Quiet", {}},
                    Weather{"Busy", {.stalls_per_second = 0.3, .longest_stall = 600ms}},
                    Weather{"Lossy",
                            {.stalls_per_second = 0.3, .longest_stall = 600ms, .lost_share = 0.02}},
                    Weather{"Crashing", {.crashes_per_minute = 2}}),
    [](const auto& each) { return each.param.name; });

// A person who stands at the goal can leave only past the robot; before, both waited for ever.
TEST(Drive, MakesRoomForWhoComesTowardsIt) {
  const Course floor = course();
  const DriveResult result = floor.drive({.seed = 9170});
  EXPECT_EQ(result.outcome, Outcome::kArrived) << result.why;
  EXPECT_EQ(result.contacts, 0U);
  EXPECT_TRUE(std::ranges::any_of(result.log, [](const std::string& line) {
    return line.find("makes room") != std::string::npos;
  }));
}

TEST(Drive, TheSameSeedGivesTheSameDrive) {
  const Course floor = course();
  const DriveSettings settings{.seed = 3,
                               .load = {.stalls_per_second = 0.5, .longest_stall = 500ms}};
  const DriveResult first = floor.drive(settings);
  const DriveResult second = floor.drive(settings);
  EXPECT_EQ(first.seconds, second.seconds);
  EXPECT_EQ(first.off_goal, second.off_goal);
  EXPECT_EQ(first.log, second.log);
}

}  // namespace drives_test
}  // namespace rack::drives
