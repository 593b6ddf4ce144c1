// Maps of made drives: what is judged with logs of other buildings.
#include "tools/evaluation/made_drives/made_drive.h"

#include <cmath>

#include <gtest/gtest.h>

#include "components/mapping/map_maker.h"
#include "tools/evaluation/mcl_eval/evaluation.h"
#include "tools/evaluation/mcl_eval/truth.h"

namespace rack::made_drives {

namespace made_drive_test {

struct Read {
  mapping::Drive drive{};
  mcl_eval::Truth truth{};
};

Read read(const std::vector<MadeScan>& scans) {
  const auto log = localisation::read_carmen(to_carmen(scans));
  EXPECT_TRUE(log.ok());
  const auto truth = mcl_eval::read_truth(to_truth(scans), *log);
  EXPECT_TRUE(truth.ok());
  return {mapping::drive_of(*log, 0), *truth};
}

double mean_error(const std::vector<Pose>& poses, const mcl_eval::Truth& truth) {
  return mcl_eval::mean(mcl_eval::track_error(poses, truth).metres);
}

TEST(CarvedFloor, HasWallsBetweenFreeAndSolid) {
  CarvedFloor floor(10, 5);
  floor.carve(1, 1, 9, 4);
  floor.put(4, 2, 5, 3);
  EXPECT_TRUE(floor.is_free(2, 2));
  EXPECT_FALSE(floor.is_free(4.5, 2.5));
  EXPECT_FALSE(floor.is_free(0.5, 2));
  EXPECT_FALSE(floor.is_free(-1, 100));
  EXPECT_EQ(floor.walls().lines.size(), 8U) << "a room and a box";
}

TEST(MadeDrive, StaysInFreeSpaceAndIsTheSameAgain) {
  for (const bool is_campus : {false, true}) {
    const Site site = is_campus ? campus(1) : laboratory(1);
    const auto scans = drive(site, {.length = 150});
    ASSERT_GT(scans.size(), 500U);
    for (const MadeScan& scan : scans)
      ASSERT_TRUE(site.floor.is_free(scan.truth.y / 1000, scan.truth.x / 1000));
    EXPECT_EQ(to_carmen(scans), to_carmen(drive(site, {.length = 150})));
  }
}

struct Result {
  double before;  // m, mean error
  double after;
  double doubtful;   // share of what was driven more than once
  double uncertain;  // mm
};

// A ring of corridors and rooms, driven one and a half times, with an odometry that drifts.
Result map_of_laboratory() {
  const Read made = read(drive(laboratory(1), {.seed = 1, .length = 160, .scan_distance = 0.3}));
  std::vector<Pose> odometry;
  for (const mapping::DriveScan& scan : made.drive.scans) odometry.push_back(scan.odometry);
  const auto map = mapping::make_map(made.drive, {}, [](auto, auto, auto) { return true; });
  EXPECT_TRUE(map.ok());
  return {mean_error(odometry, made.truth), mean_error(map->poses, made.truth),
          map->doubts.distance / map->doubts.compared, map->uncertain};
}

TEST(MadeDrive, MapIsRight) {
  const Result result = map_of_laboratory();
  EXPECT_GT(result.before, 3);
  EXPECT_LT(result.after, 0.3);
  EXPECT_LT(result.doubtful, 0.02);
  EXPECT_LT(result.uncertain, 500) << "it has loops";
}

// Three people walk along with the robot, and a corridor has little else that moves relative to it.
TEST(MadeDrive, PeopleInACorridorDoNotShortenIt) {
  for (const std::uint64_t seed : {3U, 5U}) {
    const auto scans = drive(campus(seed), {.seed = seed, .length = 150, .scale = 0});
    const Read made = read(scans);
    const auto map = mapping::make_map(made.drive, {}, [](auto, auto, auto) { return true; });
    ASSERT_TRUE(map.ok());
    const Pose is = map->poses.back() - map->poses.front();
    const Pose should = scans.back().truth - scans.front().truth;
    EXPECT_NEAR(std::hypot(is.x, is.y), std::hypot(should.x, should.y), 1000) << seed;
    EXPECT_GT(map->uncertain, 500) << "there is no loop";
    EXPECT_GT(map->without_loop.distance, 140000);
  }
}

}  // namespace made_drive_test

}  // namespace rack::made_drives
