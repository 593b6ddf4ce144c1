#include "tools/timsctl/nav_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace timsctl {
namespace nav_report_test {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

namespace pilot = rack::pilot_state;

WhereFacts all_well() {
  WhereFacts facts;
  facts.position = "Position/1/0";
  facts.position_state = "on";
  facts.mcl = "Mcl/1/0";
  facts.mcl_state = "on";
  facts.mcl_has_map = facts.mcl_sends_pose = true;
  facts.samples = {500, 0.05};
  facts.apart_m = 0.02;
  facts.age_s = 0.03;
  return facts;
}
std::string only(const WhereFacts& facts) {
  const auto found = missing(facts);
  EXPECT_THAT(found, SizeIs(1));
  return found.empty() ? "" : found[0].what + " -> " + found[0].next;
}

TEST(Where, NothingIsMissing) {
  EXPECT_THAT(missing(all_well()), IsEmpty());
  WhereFacts outdoors = all_well();
  outdoors.mcl.clear();
  outdoors.has_gps = true;
  EXPECT_THAT(missing(outdoors), IsEmpty());
}

TEST(Where, SuggestsWhatToDo) {
  WhereFacts facts = all_well();
  facts.position_state = "error";
  EXPECT_EQ(only(facts), "Position/1/0 is error -> `timsctl component on Position/1/0`");
  facts = all_well();
  facts.mcl.clear();
  EXPECT_THAT(only(facts), HasSubstr("nothing corrects the odometry"));
  facts = all_well();
  facts.mcl_state = "off";
  EXPECT_THAT(only(facts), HasSubstr("`timsctl component on Mcl/1/0`"));
  facts.mcl_has_map = false;
  EXPECT_THAT(only(facts), HasSubstr("nav map load FILE"));
  facts = all_well();
  facts.mcl_sends_pose = false;
  EXPECT_THAT(only(facts), HasSubstr("positionInst 0"));
  facts = all_well();
  facts.samples->spread_m = 4.2;
  facts.apart_m = 3;
  EXPECT_THAT(only(facts), HasSubstr("has not converged: its samples are spread over 4.2 m"));
  facts = all_well();
  facts.apart_m = 3;
  EXPECT_THAT(only(facts), HasSubstr("are 3.0 m apart"));
  facts = all_well();
  facts.age_s = 12;
  EXPECT_THAT(only(facts), HasSubstr("12.0 s old"));
  facts.age_s = -3;
  EXPECT_THAT(only(facts), HasSubstr("3.0 s ahead"));
}

TEST(Where, SamplesAreSpread) {
  rack::MclData data;
  EXPECT_EQ(samples_of(data).count, 0U);
  for (const int x : {1000, 2000})
    data.points.push_back({.x = x, .y = -5000, .type = rack::mcl_point::kSample});
  data.points.push_back({.x = 90000, .type = rack::mcl_point::kMeasurement});
  EXPECT_EQ(samples_of(data).count, 2U);
  EXPECT_NEAR(samples_of(data).spread_m, 0.5, 1e-9);
}

// A pilot that sends its status every second, from 1 s on.
class DriveWatchTest : public testing::Test {
 protected:
  DriveState report(std::uint32_t state, int distance_mm, int speed) {
    ++second_;
    status_ = {.recordingTime = 1000 * second_,
               .speed = speed,
               .distanceToDest = distance_mm,
               .pilotState = state};
    return look();
  }
  DriveState look() { return watch_.take(status_, tims::Time(std::chrono::seconds(second_))); }
  DriveState wait() {
    ++second_;
    return look();
  }

  std::uint32_t second_ = 0;
  rack::PilotStatusData status_;
  DriveWatch watch_{0, tims::Time(0s), 10s};
};

TEST_F(DriveWatchTest, DrivesAndArrives) {
  // As the last drive left it, before the pilot has gone on.
  status_ = {.recordingTime = 0, .distanceToDest = 0, .pilotState = pilot::kIdle};
  EXPECT_EQ(look(), DriveState::kPlanning) << "that was the last destination";
  EXPECT_EQ(report(pilot::kPlanning, -1, 0), DriveState::kPlanning);
  EXPECT_EQ(report(pilot::kRunning, 5000, 400), DriveState::kDriving);
  EXPECT_EQ(report(pilot::kRunning, 4000, 0), DriveState::kStanding);
  EXPECT_EQ(report(pilot::kRunning, 4000, -200), DriveState::kDriving);
  EXPECT_EQ(report(pilot::kIdle, 0, 0), DriveState::kArrived);
  EXPECT_TRUE(is_end(DriveState::kArrived));
  EXPECT_FALSE(is_end(DriveState::kSilent));
}

TEST_F(DriveWatchTest, NoPathIsNotAstray) {
  EXPECT_EQ(report(pilot::kPathError, -1, 0), DriveState::kNoPath);
  EXPECT_EQ(report(pilot::kRunning, 5000, 400), DriveState::kDriving);
  EXPECT_EQ(report(pilot::kPathError, 5000, 0), DriveState::kAstray);
}

TEST_F(DriveWatchTest, PatienceEnds) {
  EXPECT_EQ(report(pilot::kRunning, 5000, 400), DriveState::kDriving);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(report(pilot::kRunning, 5000, 0), DriveState::kStanding);
  EXPECT_EQ(report(pilot::kRunning, 5000, 0), DriveState::kBlocked);
}

TEST_F(DriveWatchTest, WhoMakesRoomIsNotBlocked) {
  std::vector<rack::PolarSpline> ahead(2);
  ahead[0].vMax = 500;
  ahead[1].vMax = 0;
  const auto report_at = [&](std::size_t index, int speed) {
    report(pilot::kRunning, 5000, speed);
    return watch_.take(status_, tims::Time(std::chrono::seconds(second_)),
                       std::span(ahead).subspan(index));
  };
  EXPECT_EQ(report_at(0, 300), DriveState::kMakesRoom);
  EXPECT_EQ(report_at(0, 0), DriveState::kStanding) << "something is in its way aside";
  for (int i = 0; i < 30; ++i) EXPECT_EQ(report_at(1, 0), DriveState::kWaitsAside) << i;
  EXPECT_FALSE(is_end(DriveState::kWaitsAside));
  EXPECT_EQ(report(pilot::kRunning, 5000, 400), DriveState::kDriving);
}

TEST_F(DriveWatchTest, TurningAtRestIsGettingFurther) {
  for (std::uint32_t i = 0; i < 20; ++i) {
    ++second_;
    status_ = {
        .recordingTime = 1000 * second_, .distanceToDest = 100, .pilotState = pilot::kRunning};
    status_.pos.rho = static_cast<float>((6200 + 50 * i) % 6283) / 1000;
    EXPECT_EQ(look(), i == 0 ? DriveState::kStanding : DriveState::kTurning) << i;
  }
}

TEST_F(DriveWatchTest, APilotThatIsGone) {
  EXPECT_EQ(report(pilot::kRunning, 5000, 400), DriveState::kDriving);
  EXPECT_EQ(wait(), DriveState::kDriving) << "nothing new since a second";
  EXPECT_EQ(wait(), DriveState::kSilent);
  EXPECT_EQ(report(pilot::kRunning, 5000, 400), DriveState::kDriving) << "it is back";
}

TEST_F(DriveWatchTest, ADestinationThatIsGone) {
  for (int second = 0; second < 10; ++second)
    EXPECT_EQ(report(pilot::kIdle, -1, 0), DriveState::kPlanning) << "it has just restarted";
  EXPECT_EQ(report(pilot::kIdle, -1, 0), DriveState::kDropped);
}

TEST_F(DriveWatchTest, ARestartedPilotDrivesOn) {
  EXPECT_EQ(report(pilot::kRunning, 5000, 400), DriveState::kDriving);
  for (int second = 0; second < 5; ++second)
    EXPECT_EQ(report(pilot::kIdle, -1, 0), DriveState::kPlanning);
  EXPECT_EQ(report(pilot::kRunning, 4900, 400), DriveState::kDriving);
}

TEST(ObstacleText, NamesWhatIsAheadOrNearest) {
  rack::ChassisParamData hull;
  hull.boundaryFront = hull.boundaryBack = 400;
  hull.boundaryLeft = hull.boundaryRight = 300;
  rack::Scan2dData scan;
  const auto with = [&](int x, int y, int type = 0) {
    scan.points.push_back({.x = x, .y = y, .type = type});
    return obstacle_text(scan, hull);
  };
  EXPECT_EQ(obstacle_text(scan, hull), "");
  EXPECT_EQ(with(600, 0, rack::scan_point::kInvalid), "");
  EXPECT_EQ(with(1410, 0), "") << "more than 1 m away";
  EXPECT_EQ(with(-1300, 0), "an obstacle is 0.90 m behind");
  EXPECT_EQ(with(0, 850), "an obstacle is 0.55 m to the right");
  EXPECT_EQ(with(1000, 100), "an obstacle is 0.60 m ahead") << "though the other one is nearer";
  EXPECT_EQ(with(100, -320), "an obstacle is 0.02 m to the left");
}

TEST(PathSummary, AddsUpLengthsAndTimes) {
  rack::PolarSpline spline;
  spline.length = 2000;
  spline.vStart = spline.vEnd = spline.vMax = 500;
  spline.accMax = spline.decMax = 500;
  std::vector<rack::PolarSpline> path{spline, spline};
  path[1].length = -1000;
  const PathSummary sum = summary_of(path);
  EXPECT_NEAR(sum.length_m, 3, 1e-9);
  EXPECT_NEAR(sum.seconds, 6, 0.01);
  EXPECT_EQ(summary_of({}).seconds, 0);
}

}  // namespace nav_report_test
}  // namespace timsctl
