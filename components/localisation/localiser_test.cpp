// The localiser in worlds that are known: a floor plan, a robot that drives through it, odometry
// and scans with noise.
#include "components/localisation/localiser.h"

#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include <gtest/gtest.h>

#include "components/localisation/mcl_messages.h"
#include "components/localisation/ros_map.h"
#include "tests/support/counted_new.h"
#include "tests/support/patience.h"

namespace rack::localisation {

namespace localiser_test {

// 14 m x 10 m with rooms and pillars, so that no place looks like another.
DxfDrawing plan() {
  DxfDrawing drawing;
  const auto wall = [&](double x, double y, double x2, double y2) {
    drawing.lines.push_back({{x, y}, {x2, y2}});
  };
  wall(0, 0, 14, 0);
  wall(14, 0, 14, 10);
  wall(14, 10, 0, 10);
  wall(0, 10, 0, 0);
  wall(5, 0, 5, 3);
  wall(9, 0, 9, 2);
  wall(0, 6.5, 3, 6.5);
  wall(6, 10, 6, 7.5);
  wall(10, 6.8, 14, 6.8);
  wall(10, 6.8, 10, 7.4);
  wall(2, 4.6, 2.5, 4.6);
  wall(2.5, 4.6, 2.5, 5.2);
  return drawing;
}

// The field of the plan itself, or of its cells as in a map of ROS.
GridMap map_of_plan(bool by_ros) {
  const auto map = read_map(plan(), 1000, 0, 0, 50);
  EXPECT_TRUE(map.ok());
  if (!by_ros) return *map;
  const auto info = read_ros_yaml(to_ros_yaml(*map, "plan.pgm"));
  EXPECT_TRUE(info.ok());
  return grid_of(*info, grey_of(*map));
}

class World {
 public:
  explicit World(std::uint64_t seed, bool by_ros = false)
      : rays_(plan(), 1000, 0, 0), random_(seed) {
    const GridMap map = map_of_plan(by_ros);
    auto field = LikelihoodField::of(map, {});
    EXPECT_TRUE(field.ok());
    field_ = std::make_unique<LikelihoodField>(std::move(field).value());
    walls_ = WallLines(map);
  }

  // Round the room, on an ellipse.
  static Pose place(double distance) {
    const double part = distance / 5000;
    return {.x = 5000 + 3000 * std::sin(part),
            .y = 7000 + 4600 * std::cos(part),
            .rho = heading(std::atan2(-4600 * std::sin(part), 3000 * std::cos(part)))};
  }

  void drive(double distance) {
    const Pose before = truth_;
    travelled_ += distance;
    truth_ = place(travelled_);
    Pose step = truth_ - before;
    const double turned = std::abs(signed_angle(step.rho));
    step.x = step.x * scale_ * (1 + 0.02 * normal()) + slip_distance_ * normal();
    step.rho = signed_angle(step.rho) + (0.05 * turned + 0.002 + slip_turn_) * normal();
    odometry_ = odometry_ + step;
  }
  void carry_to(double distance) {
    travelled_ = distance;
    truth_ = place(distance);
  }
  std::span<const BeamEnd> scan() {
    std::array<double, 181> ranges{};
    rays_.cast({{truth_.x, truth_.y}, truth_.rho - kPi / 2, kPi / 180}, 30000, ranges);
    beams_.clear();
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      double range = ranges[i] + 30 * normal();
      if (random_.uniform() < static_cast<float>(people_))
        range *= static_cast<double>(random_.uniform());
      if (i >= hidden_.first && i < hidden_.second) range = std::min(range, 600 + 30 * normal());
      const double angle = -kPi / 2 + static_cast<double>(i) * kPi / 180;
      beams_.push_back({static_cast<float>(range * std::cos(angle)),
                        static_cast<float>(range * std::sin(angle))});
    }
    return beams_;
  }

  [[nodiscard]] const LikelihoodField& field() const { return *field_; }
  [[nodiscard]] const WallLines* walls() const { return has_walls_ ? &walls_ : nullptr; }
  void leave_out_walls() { has_walls_ = false; }
  [[nodiscard]] const Pose& odometry() const { return odometry_; }
  [[nodiscard]] std::array<double, 3> error(const Pose& pose) const {
    return {pose.x - truth_.x, pose.y - truth_.y, signed_angle(pose.rho - truth_.rho)};
  }
  [[nodiscard]] double position_error(const Pose& pose) const {
    return std::hypot(error(pose)[0], error(pose)[1]);
  }
  void make_odometry_wrong(double scale) { scale_ = scale; }
  // As much as the filter takes for granted, of two steps of 50 mm for each scan that it takes.
  void make_odometry_as_bad_as(const FilterSettings& settings) {
    slip_distance_ = (settings.distance_least + settings.along_by_distance * 100) / std::sqrt(2);
    slip_turn_ = (settings.turn_least + settings.turn_by_distance * 0.1) / std::sqrt(2);
  }
  void let_people_in(double share) { people_ = share; }
  // Before the part of the scan from the first beam to the last.
  void put_somebody_before(std::size_t first, std::size_t last) { hidden_ = {first, last}; }

 private:
  double normal() { return static_cast<double>(random_.normal()); }

  FloorMap rays_;
  Random random_;
  std::unique_ptr<LikelihoodField> field_;
  WallLines walls_;
  bool has_walls_ = true;
  double travelled_ = 0;
  double scale_ = 1;
  double people_ = 0;
  std::pair<std::size_t, std::size_t> hidden_{};
  double slip_distance_ = 0;  // mm a step
  double slip_turn_ = 0;      // rad a step
  Pose truth_ = place(0);
  Pose odometry_{.x = 123, .y = -456, .rho = 2};
  std::vector<BeamEnd> beams_;
};

double run(World& world, Localiser& localiser, int steps) {
  double most = 0;
  for (int i = 0; i < steps; ++i) {
    world.drive(50);
    localiser.take(world.field(), world.odometry(), world.scan(), world.walls());
    most = std::max(most, world.position_error(localiser.pose()));
  }
  return most;
}

TEST(Localiser, TracksFromBesideTheTruth) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    World world(seed);
    Localiser localiser({}, seed);
    Pose start = World::place(0);
    start.x += 400;
    start.rho += 0.2;
    localiser.start_at(start, 500, 0.26);
    run(world, localiser, 40);
    EXPECT_LT(run(world, localiser, 500), 120) << seed;
  }
}

// In the frame of the map: half a cell would be 25 mm.
TEST(Localiser, IsNotBesideTheTruthOnAverage) {
  for (const bool by_ros : {false, true}) {
    std::array<double, 3> sum{};
    int count = 0;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      World world(seed, by_ros);
      Localiser localiser({}, seed);
      localiser.start_at(World::place(0), 100, 0.1);
      for (int i = 0; i < 600; ++i, ++count) {  // once round, and a bit
        run(world, localiser, 1);
        const auto error = world.error(localiser.pose());
        for (std::size_t k = 0; k < 3; ++k) sum[k] += error[k];
      }
    }
    EXPECT_NEAR(sum[0] / count, 0, 5) << by_ros;
    EXPECT_NEAR(sum[1] / count, 0, 5) << by_ros;
    EXPECT_NEAR(degrees(sum[2] / count), 0, 0.1) << by_ros;
  }
}

TEST(Localiser, FindsItselfAnywhere) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    World world(seed);
    world.drive(3000.0 * static_cast<double>(seed));
    Localiser localiser({}, seed);
    localiser.start_anywhere();
    run(world, localiser, 100);  // 5 m
    EXPECT_LT(run(world, localiser, 100), 150) << seed;
  }
}

TEST(Localiser, IsFoundAgainWhenItWasCarriedAway) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    World world(seed);
    Localiser localiser({}, seed);
    localiser.start_at(World::place(0), 100, 0.1);
    run(world, localiser, 200);
    world.carry_to(10000 + 15000);  // half-way round
    run(world, localiser, 200);     // 10 m
    if (run(world, localiser, 100) < 200) ++found;
  }
  EXPECT_GE(found, 19);
}

// Started with a heading that is 70 degrees wrong, as by a robot that turned meanwhile; it stands.
// Rarely no beam passes through a wall there: then all could be people.
TEST(Localiser, AWrongStartIsNotCertainAndFoundAgain) {
  int certain = 0;
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    World world(seed);
    const double distance = 1500.0 * static_cast<double>(seed);
    world.drive(distance);
    Pose start = World::place(distance);
    start.rho = heading(start.rho + 1.2);
    Localiser localiser({}, seed);
    localiser.start_at(start, 500, 0.26);
    bool was_certain = false;
    const auto is_wrong = [&] {
      const auto error = world.error(localiser.pose());
      return std::hypot(error[0], error[1]) > 500 || std::abs(error[2]) > radians(10.0);
    };
    for (int i = 0; i < 40; ++i) {
      localiser.take(world.field(), world.odometry(), world.scan(), world.walls());
      was_certain |= is_wrong() && is_sure(localiser.now(), 500);
    }
    if (was_certain) ++certain;
    if (!is_wrong() && is_sure(localiser.now(), 500)) ++found;
  }
  EXPECT_LE(certain, 1);
  EXPECT_GE(found, 18);
}

TEST(Localiser, LivesWithBadOdometryAndPeople) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    World world(seed);
    world.make_odometry_wrong(1.1);
    world.let_people_in(0.3);
    Localiser localiser({}, seed);
    localiser.start_at(World::place(0), 100, 0.1);
    EXPECT_LT(run(world, localiser, 500), 350) << seed;
  }
}

// More and more of them come to it and stay, before 40 of 181 beams. Somewhere a scan fits better,
// but none of its beams goes through a wall.
TEST(Localiser, SearchesNotForItselfWhilePeopleStandBeforeIt) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    World world(seed);
    Localiser localiser({}, seed);
    localiser.start_at(World::place(0), 100, 0.1);
    run(world, localiser, 200);
    for (std::size_t i = 0; i < 1000; ++i) {
      world.put_somebody_before(60, 60 + std::min<std::size_t>(i / 5, 40));
      localiser.take(world.field(), world.odometry(), world.scan());
      ASSERT_EQ(localiser.filter().injected(), 0U) << seed << " " << i;
      ASSERT_LT(world.position_error(localiser.pose()), 300) << seed << " " << i;
      ASSERT_TRUE(is_sure(localiser.estimate(), 500)) << seed << " " << i;
    }
  }
}

// The wheels stand still while somebody pushes the robot.
TEST(Localiser, SeesThatTheOdometryStandsStill) {
  World world(1);
  Localiser localiser({}, 1);
  localiser.start_at(World::place(0), 100, 0.1);
  run(world, localiser, 100);
  const Pose still = world.odometry();
  for (int i = 0; i < 20; ++i) {
    world.drive(50);
    localiser.take(world.field(), still, world.scan(), world.walls());
  }
  EXPECT_LT(world.position_error(localiser.pose()), 250);
}

// e^T C^-1 e, by Cholesky's decomposition.
double nees(const std::array<double, 3>& e, const Covariance& c) {
  const double l11 = std::sqrt(c.xx);
  const double l21 = c.xy / l11;
  const double l22 = std::sqrt(c.yy - l21 * l21);
  const double l31 = c.x_rho / l11;
  const double l32 = (c.y_rho - l31 * l21) / l22;
  const double l33 = std::sqrt(c.rho_rho - l31 * l31 - l32 * l32);
  const double a = e[0] / l11;
  const double b = (e[1] - l21 * a) / l22;
  const double d = (e[2] - l31 * a - l32 * b) / l33;
  return a * a + b * b + d * d;
}

// Normalised estimation error squared: 3 on average for a correct covariance.
double mean_nees(bool by_ros, bool has_walls) {
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= tims::test::rounds(30); ++seed) {
    World world(seed, by_ros);
    if (!has_walls) world.leave_out_walls();
    world.make_odometry_as_bad_as({});
    Localiser localiser({}, seed);
    localiser.start_at(World::place(0), 100, 0.1);
    run(world, localiser, 100);
    for (int i = 0; i < 20; ++i) {
      run(world, localiser, 20);
      const Estimate now = localiser.now();  // of two steps one is of odometry alone
      sum += nees(world.error(now.pose), now.covariance);
      ++count;
    }
  }
  return sum / count;
}

TEST(Localiser, ItsCovarianceIsHonest) {
  const double plan = mean_nees(false, true);

  EXPECT_GT(plan, 1.5);
  EXPECT_LT(plan, 3.2) << "the covariance is too small";
}

// For a grid the covariance is larger than the error: cells of real maps are worse than
// these. The same holds for the filter alone.
TEST(Localiser, ByCellsOrWithoutWallsTheCovarianceIsConservative) {
  for (const bool has_walls : {true, false})
    for (const bool by_ros : {true, false}) {
      if (has_walls && !by_ros) continue;
      const double nees = mean_nees(by_ros, has_walls);

      EXPECT_GT(nees, 0.5) << by_ros << has_walls;
      EXPECT_LT(nees, 3.2) << by_ros << has_walls;
    }
}

// The last centimetres are the walls'.
TEST(Localiser, WallsMakeItBetter) {
  for (const bool by_ros : {false, true}) {
    std::array<double, 2> sum{};
    for (const bool has_walls : {false, true})
      for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        World world(seed, by_ros);
        world.let_people_in(0.2);
        if (!has_walls) world.leave_out_walls();
        Localiser localiser({}, seed);
        localiser.start_at(World::place(0), 100, 0.1);
        run(world, localiser, 50);
        for (int i = 0; i < 300; ++i) {
          run(world, localiser, 1);
          sum[has_walls ? 1 : 0] += world.position_error(localiser.pose()) / 1500;
        }
      }
    EXPECT_LT(sum[1], 0.8 * sum[0]) << by_ros;
    EXPECT_LT(sum[1], 15) << by_ros << ", mm";
  }
}

// --- a place that looks like another one

// A corridor that looks the same from both ends but for a niche behind one of them.
DxfDrawing corridor() {
  DxfDrawing drawing;
  drawing.lines = {{{0, 0}, {20, 0}},  {{20, 0}, {20, 2}}, {{20, 2}, {16, 2}}, {{16, 2}, {16, 5}},
                   {{16, 5}, {13, 5}}, {{13, 5}, {13, 2}}, {{13, 2}, {0, 2}},  {{0, 2}, {0, 0}}};
  return drawing;
}

struct Search {
  int sure = 0;   // of the scans that do not show which end it is
  int wrong = 0;  // and at the other end
  bool is_found = false;
};

constexpr int kToAndFro = 150;

// It looks at the west end, which is like the east one, going to it and back; then it drives
// backwards past the niche.
Search search_in_corridor(std::uint64_t seed, const LikelihoodField& field, bool begins_wrong) {
  const FloorMap rays(corridor(), 1000, 0, 0);
  Localiser localiser({}, seed);
  localiser.start_anywhere();
  if (begins_wrong)  // at the other end
    localiser.start_at({.x = 1000, .y = 16500, .rho = kPi / 2}, 100, 0.1);
  Random noise(seed);
  std::vector<BeamEnd> beams;
  std::array<double, 181> ranges{};
  Search search;
  for (int i = 0; i < kToAndFro + 140; ++i) {
    const int part = i < kToAndFro ? i % 50 : 50 + i - kToAndFro;
    const double east = 1000 + 100.0 * std::abs(25 - part);
    const Pose truth{.x = 1000, .y = east, .rho = 3 * kPi / 2};  // x north, y east
    rays.cast({{truth.x, truth.y}, truth.rho - kPi / 2, kPi / 180}, 6000, ranges);
    beams.clear();
    for (std::size_t k = 0; k < ranges.size(); ++k) {
      if (ranges[k] >= 6000) continue;  // nothing seen
      const double range = ranges[k] + 20 * static_cast<double>(noise.normal());
      const double angle = -kPi / 2 + static_cast<double>(k) * kPi / 180;
      beams.push_back({static_cast<float>(range * std::cos(angle)),
                       static_cast<float>(range * std::sin(angle))});
    }
    localiser.take(field, {.x = -east}, beams);
    const Pose off = localiser.pose() - truth;
    const bool is_near = std::hypot(off.x, off.y) < 500 && std::abs(signed_angle(off.rho)) < 0.3;
    const bool sure = is_sure(localiser.estimate(), 500);
    if (i < kToAndFro && sure) ++search.sure;
    if (i < kToAndFro && sure && !is_near) ++search.wrong;
    search.is_found = is_near && sure;
  }
  return search;
}

TEST(Localiser, IsNotSureWherePlacesLookAlikeAndFoundWhenTheyDoNot) {
  const auto map = read_map(corridor(), 1000, 0, 0, 50);
  ASSERT_TRUE(map.ok());
  const auto field = LikelihoodField::of(*map, {});
  ASSERT_TRUE(field.ok());
  int sure = 0;
  int found = 0;
  int back = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Search search = search_in_corridor(seed, *field, false);
    sure += search.sure;
    if (search.is_found) ++found;
    const Search wrong = search_in_corridor(seed, *field, true);
    EXPECT_GT(wrong.wrong, kToAndFro / 2) << "nothing there shows that it is wrong";
    if (wrong.is_found) ++back;
  }
  EXPECT_LT(sure, 10 * kToAndFro / 4) << "of " << 10 * kToAndFro;
  EXPECT_EQ(found, 10);
  EXPECT_GE(back, 9);
}

// Two halls, alike but for four pillars in the second.
void put_pillars(DxfDrawing& drawing, double x) {
  for (const double px : {1.5, 3.0, 4.5, 6.0})
    for (const double py : {1.2, 4.8})
      drawing.lines.insert(drawing.lines.end(), {{{x + px, py}, {x + px + 0.4, py}},
                                                 {{x + px + 0.4, py}, {x + px + 0.4, py + 0.4}},
                                                 {{x + px + 0.4, py + 0.4}, {x + px, py + 0.4}},
                                                 {{x + px, py + 0.4}, {x + px, py}}});
}
DxfDrawing halls(bool people) {
  DxfDrawing drawing;
  for (const double x : {0.0, 20.0})
    drawing.lines.insert(drawing.lines.end(), {{{x, 0}, {x + 8, 0}},
                                               {{x + 8, 0}, {x + 8, 6}},
                                               {{x + 8, 6}, {x, 6}},
                                               {{x, 6}, {x, 0}},
                                               {{x + 3.6, 6}, {x + 3.6, 5.3}}});
  put_pillars(drawing, 20);
  if (people) put_pillars(drawing, 0);
  return drawing;
}

// In the first hall people stand for eight scans where the second one has its pillars: what is
// seen then is the second one, to a hair.
TEST(Localiser, StaysWherePeopleMakeAPlaceLookLikeAnother) {
  const auto map = read_map(halls(false), 1000, 0, 0, 50);
  ASSERT_TRUE(map.ok());
  const auto field = LikelihoodField::of(*map, {});
  ASSERT_TRUE(field.ok());
  const FloorMap alone(halls(false), 1000, 0, 0);
  const FloorMap with_people(halls(true), 1000, 0, 0);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Localiser localiser({}, seed);
    Random noise(seed);
    std::vector<BeamEnd> beams;
    std::array<double, 181> ranges{};
    double farthest = 0;
    for (int i = 0; i < 60; ++i) {
      const Pose truth{.x = 3000, .y = 1500 + 80.0 * i, .rho = kPi / 2};  // x north, y east
      const bool people = i >= 30 && i < 38;
      (people ? with_people : alone)
          .cast({{truth.x, truth.y}, truth.rho - kPi / 2, kPi / 180}, 12000, ranges);
      beams.clear();
      for (std::size_t k = 0; k < ranges.size(); ++k) {
        const double range = ranges[k] + 20 * static_cast<double>(noise.normal());
        const double angle = -kPi / 2 + static_cast<double>(k) * kPi / 180;
        beams.push_back({static_cast<float>(range * std::cos(angle)),
                         static_cast<float>(range * std::sin(angle))});
      }
      if (i == 0) localiser.start_at(truth, 100, 0.1);
      localiser.take(*field, {.x = 80.0 * i}, beams);
      const Pose off = localiser.pose() - truth;
      farthest = std::max(farthest, std::hypot(off.x, off.y));
    }
    EXPECT_LT(farthest, 500) << seed;
  }
}

TEST(Localiser, TheSameSeedGivesTheSamePoses) {
  const auto poses_of = [](std::uint64_t seed) {
    World world(1);
    Localiser localiser({}, seed);
    localiser.start_anywhere();
    std::vector<double> poses;
    for (int i = 0; i < 100; ++i) {
      run(world, localiser, 1);
      poses.push_back(localiser.pose().x);
    }
    return poses;
  };
  EXPECT_EQ(poses_of(5), poses_of(5));
  EXPECT_NE(poses_of(5), poses_of(6));
}

TEST(Localiser, StandingStillItTakesNothing) {
  World world(1);
  Localiser localiser({}, 1);
  localiser.start_at(World::place(0), 20, 0.01);
  EXPECT_TRUE(localiser.take(world.field(), world.odometry(), world.scan(), world.walls()));
  run(world, localiser, 20);
  localiser.take(world.field(), world.odometry(), world.scan(), world.walls());
  for (int i = 0; i < 100; ++i)
    EXPECT_FALSE(localiser.take(world.field(), world.odometry(), world.scan(), world.walls()));
}

TEST(Localiser, SurvivesWhatIsNoScanAndNoPose) {
  World world(1);
  Localiser localiser({}, 1);
  localiser.start_at(World::place(0), 20, 0.01);
  run(world, localiser, 20);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kEndless = std::numeric_limits<float>::infinity();
  const std::vector<BeamEnd> broken(200, BeamEnd{kNan, kEndless});
  const std::vector<BeamEnd> far(200, BeamEnd{1e30F, -1e30F});
  for (int i = 0; i < 20; ++i) {
    world.drive(10);
    EXPECT_FALSE(localiser.take(world.field(), world.odometry(), {}, world.walls()));
    EXPECT_FALSE(localiser.take(world.field(), world.odometry(), broken, world.walls()));
    localiser.take(world.field(), world.odometry(), far, world.walls());
    Pose nowhere = world.odometry();
    nowhere.rho = static_cast<double>(kNan);
    EXPECT_FALSE(localiser.take(world.field(), nowhere, world.scan(), world.walls()));
  }
  const Pose& pose = localiser.pose();
  EXPECT_TRUE(std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.rho));
  run(world, localiser, 300);
  EXPECT_LT(run(world, localiser, 100), 150) << "and is well again";
}

// Also while it searches everywhere, where the cloud is largest.
TEST(Localiser, AllocatesNothing) {
  World world(1);
  Localiser localiser({}, 1);
  localiser.start_anywhere();
  std::size_t allocated = 0;
  for (int i = 0; i < 400; ++i) {
    if (i == 200) world.carry_to(25000);
    world.drive(50);
    const auto scan = world.scan();
    const std::size_t before = tims::test::allocations();
    localiser.take(world.field(), world.odometry(), scan, world.walls());
    allocated += tims::test::allocations() - before;
  }
  EXPECT_EQ(allocated, 0U);
}

}  // namespace localiser_test

}  // namespace rack::localisation
