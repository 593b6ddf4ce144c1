// Maps of made drives: what is judged with logs of other buildings.
#include "tools/evaluation/made_drives/made_drive.h"

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

// A ring of corridors and rooms, driven one and a half times, with an odometry that drifts.
TEST(MadeDrive, OfALaboratoryBecomesAMap) {
  const Read made = read(drive(laboratory(1), {.seed = 1, .length = 160}));
  std::vector<Pose> odometry;
  for (const mapping::DriveScan& scan : made.drive.scans) odometry.push_back(scan.odometry);
  EXPECT_GT(mean_error(odometry, made.truth), 3);
  const auto map = mapping::make_map(made.drive, {}, [](auto, auto, auto) { return true; });
  ASSERT_TRUE(map.ok());
  EXPECT_LT(mean_error(map->poses, made.truth), 0.3);
  EXPECT_GT(map->loops, 20U);
  EXPECT_GT(map->doubts.compared, 20000);
  EXPECT_LT(map->doubts.distance, 0.05 * map->doubts.compared);
}

}  // namespace made_drive_test

}  // namespace rack::made_drives
