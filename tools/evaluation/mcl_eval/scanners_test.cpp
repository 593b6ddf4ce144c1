// Synthetic logs of scanners and buildings that public logs do not contain: tracking, global
// localisation, and relocalisation.
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "components/localisation/ros_map.h"
#include "tests/support/patience.h"
#include "tools/evaluation/mcl_eval/evaluation.h"

namespace rack::mcl_eval {

namespace scanners_test {

using localisation::LikelihoodField;
using localisation::WallLines;

struct Kind {
  const char* name;
  double side;        // m, of the square
  std::size_t rooms;  // number of walls and pillars
  std::size_t beams;
  double field;      // deg
  double range_max;  // m
  std::uint32_t particles_max;
  // Relocalised within 20 m. In the yard, with beams of 40 m, only one of three is: a documented
  // limit (README).
  bool is_found_again;
};

// A square with short walls and pillars at random places, except on the circle of the robot.
DxfDrawing plan(const Kind& kind) {
  DxfDrawing drawing;
  const auto wall = [&](double x, double y, double x2, double y2) {
    drawing.lines.push_back({{x, y}, {x2, y2}});
  };
  wall(0, 0, kind.side, 0);
  wall(kind.side, 0, kind.side, kind.side);
  wall(kind.side, kind.side, 0, kind.side);
  wall(0, kind.side, 0, 0);
  Random random(5);
  const auto uniform = [&](double from, double to) {
    return from + (to - from) * static_cast<double>(random.uniform());
  };
  for (std::size_t i = 0; i < kind.rooms;) {
    const double x = uniform(0, kind.side);
    const double y = uniform(0, kind.side);
    const double length = uniform(0.5, 5);
    const double from_path =
        std::abs(std::hypot(x - kind.side / 2, y - kind.side / 2) - kind.side / 4);
    if (from_path < length + 0.7) continue;
    const double turn = i % 3 == 0 ? uniform(0, kPi) : i % 3 == 1 ? 0 : kPi / 2;
    wall(x, y, x + length * std::cos(turn), y + length * std::sin(turn));
    ++i;
  }
  return drawing;
}

struct Made {
  localisation::CarmenLog log;
  Truth poses;
};

// Odometry with a small slip, range noise of 15 mm, 0.1 m between scans.
Made drive(const Kind& kind, const FloorMap& rays) {
  Random random(7);
  const auto normal = [&] { return static_cast<double>(random.normal()); };
  const double radius = kind.side / 4;
  std::string log;
  std::string poses;
  std::vector<double> ranges(kind.beams);
  Pose odometry;
  Pose before;
  constexpr int kScans = 800;
  for (int i = 0; i < kScans; ++i) {
    const double part = i * 0.1 / radius;
    const double x = kind.side / 2 + radius * std::cos(part);
    const double y = kind.side / 2 + radius * std::sin(part);
    const double theta = part + kPi / 2;
    const Pose place = localisation::pose_of_ros(x, y, theta);
    if (i > 0) {
      Pose step = place - before;
      step.x *= 1 + 0.03 * normal();
      step.rho = signed_angle(step.rho) + 0.003 * normal();
      odometry = odometry + step;
    }
    before = place;
    const auto last = static_cast<double>(kind.beams - 1);
    const double step_deg =
        kind.field >= 360 ? kind.field / static_cast<double>(kind.beams) : kind.field / last;
    rays.cast({{place.x, place.y}, place.rho - radians(kind.field) / 2, radians(step_deg)},
              1000 * kind.range_max, ranges);
    log += fmt::format("ROBOTLASER1 0 {} {} {} {} 0.01 0 {}",
                       radians(kind.field / 2 - step_deg * last), radians(kind.field),
                       radians(step_deg), kind.range_max, kind.beams);
    for (std::size_t beam = ranges.size(); beam-- > 0;)
      log +=
          fmt::format(" {:.3f}", std::min(ranges[beam] / 1000 + 0.015 * normal(), kind.range_max));
    const auto reported = localisation::ros_of_pose(odometry);
    const std::string pose =
        fmt::format("{:.4f} {:.4f} {:.5f}", reported.x, reported.y, reported.theta);
    log += fmt::format(" 0 {0} {0} 0 0 0 0 0 {1} host {1}\r\n", pose, 0.1 * i);
    poses += fmt::format("{} {} {} 0 0 0 {} {}\n", 0.1 * i, x, y, std::sin(theta / 2),
                         std::cos(theta / 2));
  }
  auto read = localisation::read_carmen(log);
  EXPECT_TRUE(read.ok()) << read.error().detail();
  auto truth = read_truth(poses, *read);
  EXPECT_TRUE(truth.ok()) << truth.error().detail();
  return {std::move(*read), std::move(*truth)};
}

class ScannersTest : public testing::TestWithParam<Kind> {};

TEST_P(ScannersTest, TracksFindsAndFindsAgain) {
  const FloorMap rays(plan(GetParam()), 1000, 0, 0);
  const Made made = drive(GetParam(), rays);
  const auto map = localisation::read_map(plan(GetParam()), 1000, 0, 0, 50);
  ASSERT_TRUE(map.ok()) << map.error().detail();
  const auto field = LikelihoodField::of(*map, {});
  ASSERT_TRUE(field.ok());
  const WallLines walls(*map);
  Trial trial;
  trial.walls = &walls;
  trial.settings.filter.particles_max = GetParam().particles_max;
  const auto now = [] { return 0.0; };
  const Outcome tracked = run(trial, made.log, *field, made.poses, now);
  EXPECT_FALSE(tracked.lost);
  EXPECT_LT(quantile(tracked.metres, 0.5), 0.02);
  EXPECT_LT(quantile(tracked.degrees, 0.5), 0.2);
  EXPECT_DOUBLE_EQ(tracked.share_over_1m, 0);
  int found = 0;
  int again = 0;
  constexpr int kSeeds = tims::test::rounds(3);
  for (trial.seed = 1; trial.seed <= kSeeds; ++trial.seed) {
    trial.global = true;
    const Outcome outcome = run(trial, made.log, *field, made.poses, now);
    if (outcome.found_after && *outcome.found_after <= 15 && !outcome.lost) ++found;
    trial.global = false;
    trial.kidnap = kidnapping(made.poses);
    if (!trial.kidnap) continue;
    const Outcome carried = run(trial, made.log, *field, made.poses, now);
    if (carried.refound_after && *carried.refound_after <= 20) ++again;
    trial.kidnap.reset();
  }
  EXPECT_EQ(found, kSeeds);
  if (GetParam().is_found_again) {
    EXPECT_EQ(again, kSeeds);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, ScannersTest,
    testing::Values(Kind{"hall_270deg_1081_30m", 40, 60, 1081, 270, 30, 20000, true},
                    Kind{"yard_360deg_720_80m", 80, 60, 720, 360, 80, 100000, false},
                    Kind{"rooms_240deg_683_8m", 30, 60, 683, 240, 8, 20000, true},
                    Kind{"works_180deg_361_30m_150m_wide", 150, 900, 361, 180, 30, 100000, true}),
    [](const auto& of) { return std::string(of.param.name); });

}  // namespace scanners_test

}  // namespace rack::mcl_eval
