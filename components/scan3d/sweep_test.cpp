#include "components/scan3d/sweep.h"

#include <gtest/gtest.h>

#include "components/scan3d/hall_fixture.h"
#include "tests/support/counted_new.h"
#include "tests/support/patience.h"

namespace rack::scan3d {
namespace sweep_test {

// To and fro from -0.5 to 0.5 rad in 2 s per direction, at rest.
Ride still(i32 mode = scan_mode::kPitch) {
  Ride ride;
  ride.mounting.mode = mode;
  ride.axis = [](double s) {
    const double turn = std::fmod(s, 4.0);
    return turn < 2 ? -0.55 + 0.55 * turn : 0.55 - 0.55 * (turn - 2);
  };
  return ride;
}

std::vector<Scan3dData> messages(Ride& ride, const SweepSettings& settings, double seconds) {
  Sweep sweep(settings);
  std::vector<Scan3dData> all;
  drive(ride, hall(), seconds, sweep, [&](const Scan3dData& scan) { all.push_back(scan); });
  return all;
}

SweepSettings settings_of(const Ride& ride) {
  return {.mounting = ride.mounting, .from = -0.5, .to = 0.5};
}

// The point in the middle of a flat scan is ahead of the ladar.
TEST(Sweep, PlacesPointsByTheAxis) {
  struct Case {
    i32 mode;
    double axis;
    double angle;
    Place wanted;
  };
  constexpr double kHalf = kPi / 2;
  const std::vector<Case> cases = {
      {scan_mode::kPitch, 0.5, 0, {std::cos(0.5), 0, -std::sin(0.5)}},  // up
      {scan_mode::kPitch, 0.5, kHalf, {0, 1, 0}},
      {scan_mode::kRoll, 0.5, 0, {1, 0, 0}},
      {scan_mode::kRoll, 0.5, kHalf, {0, std::cos(0.5), std::sin(0.5)}},
      {scan_mode::kYaw, 0.5, 0, {std::cos(0.5), std::sin(0.5), 0}},
      {scan_mode::kYaw, 0.5, kHalf, {0, 0, 1}},  // down
      {scan_mode::kTop, 0.5, 0, {0, 0, -1}},
      {scan_mode::kTop, 0.5, kHalf, {std::cos(0.5), std::sin(0.5), 0}},
      {scan_mode::kTopDown, 0.5, 0, {0, 0, 1}},
      {scan_mode::kTopDown, 0.5, -kHalf, {std::cos(0.5), std::sin(0.5), 0}},
  };
  for (const Case& c : cases) {
    Sweep sweep({.mounting = {.mode = c.mode}, .from = 0.4, .to = 0.5, .scans_max = 1});
    Scan3dData scan;
    LadarData ladar{.maxRange = 10000};
    ladar.points = {{.angle = static_cast<f32>(c.angle), .distance = 1000}};
    std::size_t got = 0;
    for (u32 i = 0; i <= 20; ++i) {
      sweep.add_axis(1000 + 10 * i, c.axis - 0.12 + 0.12 * i / 20);
      ladar.recordingTime = 1000 + 10 * i;
      sweep.add(ladar);
      while (sweep.next(scan)) {
        ++got;
        ASSERT_EQ(scan.points.size(), 1U);
        const Frame turned = c.mode == scan_mode::kPitch  ? Frame::about_y(-0.1)
                             : c.mode == scan_mode::kRoll ? Frame::about_x(-0.1)
                                                          : Frame::about_z(-0.1);
        const Place wanted = turned * (c.wanted * 1000);
        EXPECT_NEAR(scan.points[0].x, wanted.x, 8) << c.mode << ' ' << c.angle;
        EXPECT_NEAR(scan.points[0].y, wanted.y, 8) << c.mode << ' ' << c.angle;
        EXPECT_NEAR(scan.points[0].z, wanted.z, 8) << c.mode << ' ' << c.angle;
      }
    }
    EXPECT_EQ(got, 1U) << "a sweep of one flat scan";
  }
}

TEST(Sweep, IsSentAsAWholeInEachDirection) {
  Ride ride = still();
  const auto all = messages(ride, settings_of(ride), 9);
  ASSERT_EQ(all.size(), 4U);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Scan3dData& scan = all[i];
    EXPECT_EQ(scan.sectorNum, 1);
    EXPECT_NEAR(scan.scanNum, 1 / 0.55 * 75, 3);
    EXPECT_EQ(scan.scanPointNum, 181);
    EXPECT_EQ(scan.pointNum, scan.scanNum * 181);
    EXPECT_EQ(scan.points.size(), static_cast<std::size_t>(scan.pointNum));
    EXPECT_NEAR(scan.duration, 1 / 0.55 * 1000, 60);
    EXPECT_EQ(scan.maxRange, 30000);
    // First it rises: the ladar goes up, which is negative for a pitch.
    const i32 turn = i % 2 == 0 ? 0 : scan_mode::kPositiveTurn;
    EXPECT_EQ(scan.scanMode, scan_mode::kPitch | scan_mode::kSquareGrid | turn);
    const auto walls = hall();
    for (const ScanPoint& point : scan.points) {
      double nearest = 1e9;
      for (const Plane& wall : walls)
        nearest = std::min(nearest, std::abs(wall.beyond(in_world(scan, point))));
      ASSERT_LT(nearest, 25) << "at 10 m, 2 mrad";
    }
  }
}

TEST(Sweep, SectorsComeWhileItTurns) {
  Ride ride = still(scan_mode::kYaw);
  SweepSettings settings = settings_of(ride);
  settings.sectors = 4;
  const auto all = messages(ride, settings, 8.3);
  ASSERT_EQ(all.size(), 20U);
  for (std::size_t i = 0; i < all.size(); i += 5) {
    const Scan3dData& whole = all[i + 4];
    EXPECT_EQ(whole.sectorNum, 1);
    EXPECT_EQ(whole.sectorIndex, 0);
    std::size_t at = 0;
    u32 duration = 0;
    for (std::size_t sector = 0; sector < 4; ++sector) {
      const Scan3dData& part = all[i + sector];
      EXPECT_EQ(part.sectorNum, 4);
      EXPECT_EQ(part.sectorIndex, static_cast<i32>(sector));
      EXPECT_EQ(part.scanMode, whole.scanMode);
      EXPECT_NEAR(part.scanNum, whole.scanNum / 4.0, 2);
      for (const ScanPoint& point : part.points) {
        const ScanPoint& same = whole.points.at(at++);
        ASSERT_TRUE(point.x == same.x && point.y == same.y && point.z == same.z);
      }
      duration += part.duration;
    }
    EXPECT_EQ(at, whole.points.size());
    EXPECT_NEAR(duration, whole.duration, 60);
    EXPECT_EQ(all[i + 3].recordingTime, whole.recordingTime);
  }
}

// The frame of a message is the robot's at its last flat scan.
TEST(Sweep, TheReferenceIsWhereTheRobotIsAtTheEnd) {
  Ride ride = still();
  ride.robot = [](double s) { return Pose{.x = 500 * s, .rho = 0.1 * s}; };
  SweepSettings settings = settings_of(ride);
  settings.has_poses = true;
  settings.sectors = 3;
  for (const Scan3dData& scan : messages(ride, settings, 5)) {
    const double s = static_cast<double>((scan.recordingTime - stamp(0)).count()) / 1000;
    EXPECT_NEAR(scan.refPos.x, 500 * s, 2);
    EXPECT_NEAR(scan.refPos.rho, 0.1 * s, 1e-3);
  }
}

TEST(Sweep, HasNoMorePointsThanAMessageMay) {
  Ride ride = still();
  SweepSettings settings = settings_of(ride);
  settings.points_max = 20 * 181 + 100;
  for (const auto& scan : messages(ride, settings, 5)) {
    EXPECT_EQ(scan.scanNum, 20);
    EXPECT_EQ(scan.points.size(), 20U * 181);
  }
  settings.points_max = 72400;
  settings.scans_max = 7;
  auto all = messages(ride, settings, 5);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].scanNum, 7);
  settings.reduce = 4;
  all = messages(ride, settings, 5);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].scanPointNum, 46);
  settings.points_max = 10;
  settings.reduce = 1;
  all = messages(ride, settings, 5);
  for (const auto& scan : all) EXPECT_LE(scan.points.size(), 10U);
}

TEST(Sweep, AContinuousTurnReportsItsHalf) {
  for (const double rate : {1.0, -1.0}) {
    Ride ride;
    ride.mounting.mode = scan_mode::kTop;
    ride.axis = [rate](double s) { return 0.3 + rate * s; };
    SweepSettings settings{
        .mounting = ride.mounting, .from = 0, .to = kPi, .is_round = true, .sectors = 2};
    const auto all = messages(ride, settings, 13.2);
    std::vector<Scan3dData> wholes;
    for (const auto& scan : all)
      if (scan.sectorNum == 1) wholes.push_back(scan);
    ASSERT_GE(wholes.size(), 3U) << rate;
    const i32 turn = rate > 0 ? scan_mode::kPositiveTurn : 0;
    for (std::size_t i = 0; i < wholes.size(); ++i) {
      EXPECT_NEAR(wholes[i].scanNum, kPi * 75, 3);
      EXPECT_EQ(wholes[i].scanMode & scan_mode::kPositiveTurn, turn);
      if (i == 0) continue;
      EXPECT_NE(wholes[i].scanMode & scan_mode::kStartAt180,
                wholes[i - 1].scanMode & scan_mode::kStartAt180);
    }
  }
}

// --- what the world may do

TEST(Sweep, WaitsForTheAxisAndGivesUp) {
  Ride ride = still();
  const auto walls = hall();
  Sweep sweep(settings_of(ride));
  Scan3dData scan;
  EXPECT_FALSE(sweep.wanted());
  for (double s = 0.02; s < 0.2; s += 0.0133) sweep.add(flat_scan(ride, walls, s));
  EXPECT_FALSE(sweep.next(scan));
  ASSERT_TRUE(sweep.wanted());
  EXPECT_LE(sweep.wanted()->begin, stamp(0.02 - 0.0033));
  EXPECT_GE(sweep.wanted()->end, stamp(0.02 + 0.0033));
  EXPECT_EQ(sweep.losses().unplaced, 0U);
  sweep.add(flat_scan(ride, walls, 3));
  EXPECT_FALSE(sweep.next(scan));
  EXPECT_EQ(sweep.losses().unplaced, 14U) << "no sample of the axis for two seconds";
  for (int i = 0; i < 100; ++i) sweep.add(flat_scan(ride, walls, 3.1));
  EXPECT_EQ(sweep.losses().crowded, 69U);
}

TEST(Sweep, LeavesOutWhatIsNoScan) {
  Sweep sweep({});
  LadarData scan{.duration = 4'000'000'000U};
  scan.points.resize(3);
  sweep.add(scan);
  scan = {};
  sweep.add(scan);
  EXPECT_EQ(sweep.losses().broken, 2U);
  EXPECT_FALSE(sweep.wanted());
}

// Servo and position are lost, late, twice, in any order, jump, and are no numbers; scans change
// their length. What comes out can be sent, and is finite; afterwards all is well again.
TEST(Sweep, SurvivesAnything) {
  for (unsigned seed = 0; seed < tims::test::rounds(60); ++seed) {
    std::mt19937 random(seed);
    Ride ride = still(1 + static_cast<i32>(seed % 5));
    ride.points = 31;
    ride.mounting.axis = {.x = 100, .z = -400, .psi = 0.2};
    const auto walls = hall();
    SweepSettings settings = settings_of(ride);
    settings.is_round = seed % 2 == 0;
    settings.sectors = 1 + static_cast<i32>(seed % 4);
    settings.has_poses = seed % 3 != 0;
    settings.points_max = seed % 7 == 0 ? 200 : 72400;
    Sweep sweep(settings);
    Scan3dData message;
    std::vector<std::byte> body;
    const auto odd = [&] {
      constexpr double kOdd[] = {NAN, INFINITY, -INFINITY, 1e300, -1e9, 5, -0.3, 0};
      return kOdd[random() % std::size(kOdd)];
    };
    std::size_t good = 0;
    const double calm = 6;
    for (double s = 0.02; s < 20; s += 1 / 75.0) {
      const bool is_wild = s < 20 - 2 * calm;
      const auto when = [&] {
        return stamp(
            is_wild && random() % 8 == 0 ? s + static_cast<double>(random() % 4000) / 100 - 20 : s);
      };
      if (!is_wild || random() % 3 != 0)
        sweep.add_axis(when(), is_wild && random() % 10 == 0 ? odd() : ride.axis(s));
      if (!is_wild || random() % 3 != 0) {
        Position3d pose{};
        if (is_wild && random() % 10 == 0)
          pose = {.x = static_cast<i32>(random()), .rho = static_cast<f32>(odd())};
        sweep.add_pose(when(), pose);
      }
      LadarData scan = flat_scan(ride, walls, s - 0.01);
      if (is_wild && random() % 5 == 0) {
        scan.points.resize(random() % 400, {.angle = static_cast<f32>(odd()),
                                            .distance = static_cast<i32>(random())});
        scan.duration = static_cast<u32>(random() % 3 == 0 ? random() : random() % 100);
        scan.maxRange = static_cast<i32>(random());
        if (random() % 4 == 0) scan.recordingTime = static_cast<u32>(random());
      }
      sweep.add(scan);
      while (sweep.next(message)) {
        ASSERT_LE(message.points.size(), settings.points_max);
        ASSERT_EQ(message.pointNum, static_cast<i32>(message.points.size()));
        ASSERT_TRUE(codec::check(message)) << seed;
        ASSERT_TRUE(std::isfinite(message.refPos.rho.raw()));
        if (s > 20 - calm && message.sectorNum == 1) ++good;
      }
    }
    EXPECT_GE(good, 1U) << seed;
  }
}

TEST(Sweep, AllocatesNothing) {
  Ride ride = still();
  ride.points = 61;
  const auto walls = hall();
  std::vector<LadarData> scans;
  for (double s = 0.02; s < 9; s += ride.period) scans.push_back(flat_scan(ride, walls, s));
  SweepSettings settings = settings_of(ride);
  settings.sectors = 3;
  settings.has_poses = true;
  Sweep sweep(settings);
  Scan3dData message;
  reserve_all(message);
  const std::size_t before = tims::test::allocations();
  std::size_t got = 0;
  for (const LadarData& scan : scans) {
    const double s = static_cast<double>((scan.recordingTime - stamp(0)).count()) / 1000;
    sweep.add_axis(stamp(s), ride.axis(s));
    sweep.add_pose(stamp(s), {});
    sweep.add(scan);
    while (sweep.next(message)) ++got;
  }
  EXPECT_EQ(tims::test::allocations(), before);
  EXPECT_GE(got, 12U);
}

}  // namespace sweep_test
}  // namespace rack::scan3d
