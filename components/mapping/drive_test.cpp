#include "components/mapping/drive.h"

#include <cmath>

#include <gtest/gtest.h>

#include "components/geometry/random.h"

namespace rack::mapping {

namespace drive_test {

constexpr std::string_view kOdometry =
    "% Odometry(0/0)\n% recordingTime pos.x pos.y pos.z pos.phi pos.psi pos.rho\n"
    "1000 0 0 0 0 0 0\n1100 200 0 0 0 0 0.1\n1200 400 0 0 0 0 0.2\n";
constexpr std::string_view kScans =
    "% Scan2d(0/0)\n% recordingTime duration maxRange ...\n"
    "1050 13 30000 1 0 0 0 0 0 0 0 4 1\n1150 13 30000 1 0 0 0 0 0 0 0 4 2\n";

tims::Result<std::string> scan_file(std::size_t number) {
  if (number > 2) return tims::Error(tims::Errc::kSystem, "no such file");
  // seen; invalid; dynamic; at the end of what the scanner sees
  return std::string(
      "100 200 300 0 0 10\n100 300 300 16 0 10\n100 400 300 3 0 10\n100 500 30000 0 0 10\n");
}

TEST(Recording, BecomesADrive) {
  const auto drive = read_recording(kOdometry, kScans, scan_file);
  ASSERT_TRUE(drive.ok()) << drive.error().detail();
  ASSERT_EQ(drive->scans.size(), 2U);
  EXPECT_NEAR(drive->scans[0].odometry.x, 100, 1e-9) << "between two samples";
  EXPECT_NEAR(drive->scans[1].odometry.rho, 0.15, 1e-9);
  ASSERT_EQ(drive->beams(drive->scans[1]).size(), 1U);
  EXPECT_EQ(drive->beams(drive->scans[1])[0].y, 200);
}

std::string error_of(std::string_view odometry, std::string_view scans) {
  const auto drive = read_recording(odometry, scans, scan_file);
  return drive ? "" : drive.error().detail();
}

TEST(Recording, ReportsWhatIsWrongAndWhere) {
  EXPECT_EQ(error_of("1000 0 0\n", kScans),
            "odometry, line 1: 3 numbers, at least 7 expected: the wrong file?");
  EXPECT_EQ(error_of("% a\n1000 0 nan 0 0 0 0\n", kScans),
            "odometry, line 2: \"nan\" is not a number");
  EXPECT_EQ(error_of("1000 0 1e12 0 0 0 0\n", kScans),
            "odometry, line 1: a pose more than 100 km away");
  EXPECT_EQ(error_of("% nothing\n", kScans), "odometry: no line with a pose");
  EXPECT_EQ(error_of(kOdometry, "% nothing\n"), "scans: no line with a scan");
  EXPECT_EQ(error_of(kOdometry, "1050 13 30000 1 0 0 0 0 0 0 0 4 -1\n"),
            "scans, line 1: its last number is not the number of a file");
  EXPECT_EQ(error_of(kOdometry, "1050 13 30000 1 0 0 0 0 0 0 0 4 3\n"), "no such file");
  EXPECT_EQ(error_of(kOdometry, "9050 13 30000 1 0 0 0 0 0 0 0 4 1\n"),
            "no scan has odometry within a second of it: were the two recorded together?");
}

// The recorder was killed while it wrote: the last numbers may have lost digits.
TEST(Recording, AnIncompleteLastLineIsLeftOut) {
  const std::string odometry = std::string(kOdometry) + "1300 60";
  const std::string scans = std::string(kScans) + "1190 13 30000 1 0 0 0 0 0 0 0 4 1";
  const auto drive = read_recording(odometry, scans, scan_file);
  ASSERT_TRUE(drive.ok()) << drive.error().detail();
  EXPECT_EQ(drive->scans.size(), 2U);
  EXPECT_EQ(drive->remarks, (std::vector<std::string>{"odometry, line 6: incomplete, left out",
                                                      "scans, line 5: incomplete, left out"}));
  EXPECT_TRUE(read_recording(kOdometry, kScans, scan_file)->remarks.empty());
}

// Whatever a full disk or an editor makes of the three files: a drive of numbers, or what is wrong.
TEST(Recording, SurvivesMutations) {
  Random random(5);
  const auto mutated = [&](std::string text) {
    for (std::uint32_t i = 0; i < random.below(4); ++i) {
      const std::size_t at = random.below(static_cast<std::uint32_t>(text.size()));
      if (random.below(2) == 0)
        text[at] = static_cast<char>(random.below(256));
      else if (random.below(2) == 0)
        text.insert(at, text.substr(random.below(20), 30));
      else
        text.erase(at, random.below(30));
      if (text.empty()) text = "x";
    }
    return text;
  };
  int good = 0;
  for (int run = 0; run < 5000; ++run) {
    const auto file = [&](std::size_t number) -> tims::Result<std::string> {
      auto text = scan_file(number);
      if (!text) return text;
      return mutated(std::move(text).value());
    };
    const auto drive =
        read_recording(mutated(std::string(kOdometry)), mutated(std::string(kScans)), file);
    if (!drive) {
      EXPECT_FALSE(drive.error().detail().empty());
      continue;
    }
    ++good;
    for (const DriveScan& scan : drive->scans) {
      EXPECT_TRUE(std::isfinite(scan.odometry.x + scan.odometry.y + scan.odometry.rho));
      EXPECT_LE(scan.begin + scan.count, drive->ends.size());
    }
    for (const BeamEnd& end : drive->ends) EXPECT_TRUE(std::isfinite(end.x + end.y));
  }
  EXPECT_GT(good, 100);
  EXPECT_LT(good, 4900);
}

TEST(Recording, TimeThatGoesBackIsLeftOut) {
  const auto drive = read_recording(
      "1000 0 0 0 0 0 0\n1100 200 0 0 0 0 0\n500 9000 0 0 0 0 0\n1200 400 0 0 0 0 0\n", kScans,
      scan_file);
  ASSERT_TRUE(drive.ok());
  EXPECT_NEAR(drive->scans[1].odometry.x, 300, 1e-9);
}

TEST(CarmenDrive, HasTheOdometryOfTheScansOwnTime) {
  const auto log = localisation::read_carmen(
      "ODOM 0 0 0 0 0 0 1.0 h 0\nODOM 1 0 0 0 0 0 2.0 h 1\n"
      "FLASER 3 1 2 50 1 0 0 1 0 0 2.0 h 1\n");
  ASSERT_TRUE(log.ok());
  const Drive drive = drive_of(*log, 0.5);
  ASSERT_EQ(drive.scans.size(), 1U);
  EXPECT_NEAR(drive.scans[0].odometry.y, 500, 1e-6) << "x of CARMEN is y of RACK";
  EXPECT_EQ(drive.scans[0].count, 2U) << "one beam saw nothing";
}

}  // namespace drive_test

}  // namespace rack::mapping
