// The last centimetres, in rooms that are known: scans with noise, people and doors; as a floor
// plan, and as cells.
#include "components/localisation/scan_matcher.h"

#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "components/geometry/random.h"
#include "tests/support/counted_new.h"

namespace rack::localisation {

namespace scan_matcher_test {

DxfDrawing room() {
  DxfDrawing drawing;
  drawing.lines = {{{0, 0}, {12, 0}},      {{12, 0}, {12, 9}},     {{12, 9}, {0, 9}},
                   {{0, 9}, {0, 0}},       {{4, 0}, {4, 2.5}},     {{8.3, 9}, {8.3, 6.1}},
                   {{8.3, 6.1}, {10, 6}},  {{0, 5.2}, {1.8, 5.2}}, {{11, 0}, {12, 1.5}},
                   {{6.02, 4}, {6.5, 4.6}}};
  return drawing;
}
// Bare walls, open at both ends.
DxfDrawing corridor() {
  DxfDrawing drawing;
  drawing.lines = {{{0, 0}, {60, 0}}, {{0, 2}, {60, 2}}};
  return drawing;
}

class Place {
 public:
  Place(const DxfDrawing& drawing, bool as_cells, std::uint64_t seed)
      : rays_(drawing, 1000, 0, 0), random_(seed) {
    auto map = read_map(drawing, 1000, 0, 0, 50);
    EXPECT_TRUE(map.ok());
    if (as_cells) map->walls.clear();
    walls_ = WallLines(*map);
  }
  // `people`: share of beams that they cut.
  std::span<const BeamEnd> scan(const Pose& from, double noise, double people = 0) {
    std::array<double, 361> ranges{};
    rays_.cast({{from.x, from.y}, from.rho - kPi / 2, kPi / 360}, 20000, ranges);
    beams_.clear();
    double man = 0;  // of so many beams side by side
    double at = 0;
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      if (man-- <= 0 && uniform(0, 1) < people / 12) {
        man = 12;
        at = uniform(0.2, 0.9);
      }
      if (ranges[i] >= 20000) continue;
      const double range = (man > 0 ? at : 1) * ranges[i] + noise * normal();
      const double angle = -kPi / 2 + static_cast<double>(i) * kPi / 360;
      beams_.push_back({static_cast<float>(range * std::cos(angle)),
                        static_cast<float>(range * std::sin(angle))});
    }
    return beams_;
  }
  // Somewhere with half a metre of room.
  Pose anywhere() {
    for (;;) {
      const Pose pose{.x = uniform(600, 8400), .y = uniform(600, 11400), .rho = uniform(0, 6.28)};
      std::array<double, 36> ranges{};
      rays_.cast({{pose.x, pose.y}, 0, kPi / 18}, 20000, ranges);
      if (*std::ranges::min_element(ranges) > 500) return pose;
    }
  }
  Pose beside(const Pose& pose, double distance, double turn) {
    const double direction = uniform(0, 2 * kPi);
    return {.x = pose.x + distance * std::cos(direction),
            .y = pose.y + distance * std::sin(direction),
            .rho = pose.rho + (uniform(0, 1) < 0.5 ? turn : -turn)};
  }
  double normal() { return static_cast<double>(random_.normal()); }
  double uniform(double from, double to) {
    return from + (to - from) * static_cast<double>(random_.uniform());
  }
  [[nodiscard]] const WallLines& walls() const { return walls_; }

 private:
  FloorMap rays_;
  Random random_;
  WallLines walls_;
  std::vector<BeamEnd> beams_;
};

Estimate estimate_at(const Pose& pose, double distance, double turn) {
  return {
      .pose = pose,
      .covariance = {.xx = distance * distance, .yy = distance * distance, .rho_rho = turn * turn},
      .share = 1};
}
double position_error(const Pose& is, const Pose& should) {
  return std::hypot(is.x - should.x, is.y - should.y);
}
double turn_off(const Pose& is, const Pose& should) {
  return std::abs(signed_angle(is.rho - should.rho));
}

TEST(ScanMatcher, ConvergesFromThirtyCentimetresAndFiveDegrees) {
  ScanMatcher matcher;
  for (const bool as_cells : {false, true}) {
    Place place(room(), as_cells, 1);
    int converged = 0;
    for (int i = 0; i < 200; ++i) {
      const Pose truth = place.anywhere();
      const Pose start = place.beside(truth, 300, radians(5));
      const auto found =
          matcher.refined(place.walls(), place.scan(truth, 20), estimate_at(start, 200, 0.07));
      if (found && position_error(found->pose, truth) < 40 &&
          turn_off(found->pose, truth) < radians(0.6))
        ++converged;
    }
    EXPECT_GE(converged, 190) << as_cells;
  }
}

// Any result is not much worse than the estimate of the filter; and mostly far better.
TEST(ScanMatcher, MakesNoPoseWorse) {
  ScanMatcher matcher;
  for (const bool as_cells : {false, true})
    for (const double people : {0.0, 0.3}) {
      Place place(room(), as_cells, 2);
      double before = 0;
      double after = 0;
      for (int i = 0; i < 500; ++i) {
        const Pose truth = place.anywhere();
        const Pose start{.x = truth.x + 40 * place.normal(),
                         .y = truth.y + 40 * place.normal(),
                         .rho = truth.rho + 0.015 * place.normal()};
        const auto found = matcher.refined(place.walls(), place.scan(truth, 20, people),
                                           estimate_at(start, 40, 0.015));
        const Pose pose = found ? found->pose : start;
        before += position_error(start, truth);
        after += position_error(pose, truth);
        EXPECT_LT(position_error(pose, truth), position_error(start, truth) + 35)
            << i << " " << people;
        EXPECT_LT(turn_off(pose, truth), turn_off(start, truth) + radians(0.8))
            << i << " " << people;
      }
      EXPECT_LT(after, before * (people > 0 ? 0.4 : 0.3)) << people << " " << as_cells;
    }
}

// e^T C^-1 e is 3 on average for a correct covariance.
TEST(ScanMatcher, ItsCovarianceIsHonest) {
  ScanMatcher matcher;
  for (const bool as_cells : {false, true})
    for (const double noise : {5.0, 20.0, 35.0})
      for (const double people : {0.0, 0.3}) {
        Place place(room(), as_cells, 3);
        double sum = 0;
        int count = 0;
        for (int i = 0; i < 500; ++i) {
          const Pose truth = place.anywhere();
          const Pose start{.x = truth.x + 40 * place.normal(),
                           .y = truth.y + 40 * place.normal(),
                           .rho = truth.rho + 0.015 * place.normal()};
          const auto found = matcher.refined(place.walls(), place.scan(truth, noise, people),
                                             estimate_at(start, 40, 0.015));
          if (!found) continue;
          const Covariance& c = found->covariance;
          Information m;
          m << c.xx, c.xy, c.x_rho, c.xy, c.yy, c.y_rho, c.x_rho, c.y_rho, c.rho_rho;
          const Eigen::Vector3d e(found->pose.x - truth.x, found->pose.y - truth.y,
                                  signed_angle(found->pose.rho - truth.rho));
          sum += e.dot(m.ldlt().solve(e));
          ++count;
        }
        // The walls of this grid are rasterised exactly; those of real maps are not, so the
        // covariance is larger than the error here.
        EXPECT_GT(sum / count, as_cells ? 0.25 : 1.5) << noise << " " << people;
        EXPECT_LT(sum / count, 3.3) << noise << " " << people << " " << as_cells;
        EXPECT_GT(count, 400);
      }
}

TEST(ScanMatcher, DoesNotCorrectThePositionAlongACorridor) {
  ScanMatcher matcher;
  for (const bool as_cells : {false, true}) {
    Place place(corridor(), as_cells, 4);
    for (int i = 0; i < 100; ++i) {
      // x north, y east: the corridor leads to the east.
      const Pose truth{.x = 1000, .y = 30000, .rho = kPi / 2};
      const Pose start{.x = 1040, .y = 30080, .rho = kPi / 2 + 0.02};
      const auto found =
          matcher.refined(place.walls(), place.scan(truth, 20), estimate_at(start, 60, 0.03));
      ASSERT_TRUE(found);
      EXPECT_NEAR(found->pose.x, truth.x, 20);
      EXPECT_LT(turn_off(found->pose, truth), radians(0.4));
      EXPECT_NEAR(found->pose.y, start.y, 4) << "nobody knows";
      EXPECT_GT(found->covariance.yy, 55.0 * 55) << "and its covariance shows it";
      EXPECT_LT(found->covariance.xx, 12.0 * 12);
    }
  }
}

TEST(ScanMatcher, GoesNoFartherThanTheFilterAllows) {
  ScanMatcher matcher;
  Place place(room(), false, 5);
  int refused = 0;
  for (int i = 0; i < 100; ++i) {
    const Pose truth = place.anywhere();
    const Pose start = place.beside(truth, 250, 0);
    const auto found =
        matcher.refined(place.walls(), place.scan(truth, 10), estimate_at(start, 20, 0.005));
    if (!found) {
      ++refused;
      continue;
    }
    EXPECT_LT(position_error(found->pose, start), 4.1 * std::hypot(20, 10)) << i;
  }
  EXPECT_GT(refused, 60);
}

TEST(ScanMatcher, HasNoResultWithoutAScanOrAMap) {
  ScanMatcher matcher;
  Place place(room(), false, 6);
  const Pose truth = place.anywhere();
  const Estimate start = estimate_at(truth, 30, 0.01);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kEndless = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(matcher.refined(place.walls(), {}, start));
  for (const BeamEnd& end : {BeamEnd{kNan, kNan}, BeamEnd{kEndless, 1}, BeamEnd{1e30F, -1e30F},
                             BeamEnd{0, 0}, BeamEnd{kNan, 500}})
    for (const std::size_t count : {1U, 11U, 181U, 5000U})
      EXPECT_FALSE(matcher.refined(place.walls(), std::vector<BeamEnd>(count, end), start));
  const auto scan = place.scan(truth, 10);
  EXPECT_FALSE(matcher.refined(WallLines(), scan, start)) << "a map without walls";
  EXPECT_TRUE(matcher.refined(place.walls(), scan, start));
  Estimate broken = start;
  broken.covariance.xy = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(matcher.refined(place.walls(), scan, broken));
  broken = start;
  broken.pose.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(matcher.refined(place.walls(), scan, broken));
  broken = start;
  broken.pose.y = 1e12;
  EXPECT_FALSE(matcher.refined(place.walls(), scan, broken));
  // A tenth of the beams is not a number.
  std::vector<BeamEnd> holes(scan.begin(), scan.end());
  for (std::size_t i = 0; i < holes.size(); i += 10) holes[i] = {kNan, kEndless};
  const auto found = matcher.refined(place.walls(), holes, start);
  ASSERT_TRUE(found);
  EXPECT_LT(position_error(found->pose, truth), 20);
}

TEST(ScanMatcher, AllocatesNothing) {
  ScanMatcher matcher;
  Place place(room(), false, 7);
  for (int i = 0; i < 20; ++i) {
    const Pose truth = place.anywhere();
    const auto scan = place.scan(truth, 20);
    const std::size_t before = tims::test::allocations();
    const auto found = matcher.refined(place.walls(), scan, estimate_at(truth, 30, 0.01));
    EXPECT_EQ(tims::test::allocations(), before);
    EXPECT_TRUE(found);
  }
}

}  // namespace scan_matcher_test

}  // namespace rack::localisation
