// A building that looks the same after half a turn, with or without a box at one end.
#include "components/localisation/rivals.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "components/geometry/floor_map.h"
#include "components/localisation/localiser.h"
#include "components/localisation/mcl_messages.h"
#include "tests/support/patience.h"

namespace rack::localisation {
namespace rivals_test {

// 16 m x 12 m around the origin.
DxfDrawing building(bool has_box) {
  DxfDrawing drawing;
  const auto wall = [&](double x, double y, double x2, double y2) {
    drawing.lines.push_back({{x, y}, {x2, y2}});
    drawing.lines.push_back({{-x, -y}, {-x2, -y2}});
  };
  wall(-6, -8, 6, -8);
  wall(6, -8, 6, 8);
  wall(-6, -3, -3.5, -3);
  wall(3.5, -5, 6, -5);
  wall(-6, 3.5, -4, 3.5);
  wall(0.8, -0.5, 0.8, 0.5);
  if (has_box) {
    drawing.lines.push_back({{-1, -6}, {1, -6}});
    drawing.lines.push_back({{-1, -5.2}, {1, -5.2}});
    drawing.lines.push_back({{-1, -6}, {-1, -5.2}});
    drawing.lines.push_back({{1, -6}, {1, -5.2}});
  }
  return drawing;
}

class World {
 public:
  World(std::uint64_t seed, bool has_box)
      : rays_(building(has_box), 1000, 0, 0),
        field_(*LikelihoodField::of(*read_map(building(has_box), 1000, 0, 0, 50), {})),
        random_(seed),
        travelled_(static_cast<double>(random_.below(20000))) {}

  void drive(double distance) {
    const Pose before = truth();
    travelled_ += distance;
    Pose step = truth() - before;
    step.x *= 1 + 0.02 * normal();
    step.rho = signed_angle(step.rho) + 0.004 * normal();
    odometry_ = odometry_ + step;
  }
  std::span<const BeamEnd> scan() {
    std::array<double, 181> ranges{};
    const Pose at = truth();
    rays_.cast({{at.x, at.y}, at.rho - kPi / 2, kPi / 180}, 8000, ranges);
    beams_.clear();
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      if (ranges[i] >= 8000) continue;
      double range = ranges[i] + 20 * normal();
      if (random_.uniform() < 0.1F) range *= static_cast<double>(random_.uniform());  // people
      const double angle = -kPi / 2 + static_cast<double>(i) * kPi / 180;
      beams_.push_back({static_cast<float>(range * std::cos(angle)),
                        static_cast<float>(range * std::sin(angle))});
    }
    return beams_;
  }
  // On an ellipse around the pillar in the middle.
  [[nodiscard]] Pose truth() const {
    const double part = travelled_ / 4000;
    return {.x = 3000 * std::sin(part),
            .y = 5000 * std::cos(part),
            .rho = heading(std::atan2(-5000 * std::sin(part), 3000 * std::cos(part)))};
  }
  [[nodiscard]] double error(const Pose& pose) const {
    return std::hypot(pose.x - truth().x, pose.y - truth().y);
  }
  [[nodiscard]] const LikelihoodField& field() const { return field_; }
  [[nodiscard]] const Pose& odometry() const { return odometry_; }

 private:
  double normal() { return static_cast<double>(random_.normal()); }

  FloorMap rays_;
  LikelihoodField field_;
  Random random_;
  double travelled_;
  Pose odometry_{};
  std::vector<BeamEnd> beams_;
};

constexpr double kCertain = 500;  // mm

struct Drive {
  int sure_and_wrong = 0;  // scans
  int sure = 0;
  double error = 0;  // mm, at the end
};

Drive run(World& world, Localiser& localiser, int steps) {
  Drive drive;
  for (int i = 0; i < steps; ++i) {
    world.drive(50);
    localiser.take(world.field(), world.odometry(), world.scan());
    drive.error = world.error(localiser.pose());
    if (!is_sure(localiser.now(), kCertain)) continue;
    ++drive.sure;
    if (drive.error > 500) ++drive.sure_and_wrong;
  }
  return drive;
}

TEST(Rivals, KeepASymmetricBuildingUncertainForEver) {
  for (std::uint64_t seed = 1; seed <= tims::test::rounds(20); ++seed) {
    World world(seed, false);
    Localiser localiser({}, seed);
    localiser.start_anywhere();
    const Drive drive = run(world, localiser, 2000);  // 100 m
    EXPECT_EQ(drive.sure, 0) << seed;
  }
}

TEST(Rivals, AreDecidedByABox) {
  int decided = 0;
  const int rounds = static_cast<int>(tims::test::rounds(20));
  for (int seed = 1; seed <= rounds; ++seed) {
    World world(static_cast<std::uint64_t>(seed), true);
    Localiser localiser({}, static_cast<std::uint64_t>(seed));
    localiser.start_anywhere();
    const Drive drive = run(world, localiser, 1000);  // twice round
    EXPECT_EQ(drive.sure_and_wrong, 0) << seed;
    if (drive.sure > 0 && drive.error < 200) ++decided;
  }
  EXPECT_GE(decided * 10, rounds * 9);
}

TEST(Rivals, AreNotLookedForWhereTheStartIsKnown) {
  World world(1, false);
  Localiser localiser({}, 1);
  localiser.start_at(world.truth(), 100, 0.1);
  const Drive drive = run(world, localiser, 500);
  EXPECT_GE(drive.sure, 490);
  EXPECT_EQ(drive.sure_and_wrong, 0);
}

}  // namespace rivals_test
}  // namespace rack::localisation
