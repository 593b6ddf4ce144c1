#include "components/localisation/likelihood_field.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace rack::localisation {

namespace likelihood_field_test {

GridMap random_map(std::int32_t rows, std::int32_t columns, std::uint64_t seed) {
  GridMap map{.resolution = 50, .origin = {-1000, 2000}, .rows = rows, .columns = columns};
  Random random(seed);
  for (std::int32_t i = 0; i < rows * columns; ++i)
    map.cells.push_back(random.below(40) == 0 ? Cell::kOccupied : Cell::kFree);
  map.cells[0] = Cell::kOccupied;
  return map;
}

float middle(double origin, std::int32_t cell) {
  return static_cast<float>(origin + 50 * cell + 25);
}

double nearest(const GridMap& map, std::int32_t row, std::int32_t column) {
  double least = 1e9;
  for (std::int32_t r = 0; r < map.rows; ++r)
    for (std::int32_t c = 0; c < map.columns; ++c)
      if (map.at(r, c) == Cell::kOccupied) least = std::min(least, std::hypot(r - row, c - column));
  return least * map.resolution;
}

TEST(LikelihoodField, IsTheExactDistance) {
  const FieldSettings settings;
  for (std::uint64_t seed = 1; seed < 4; ++seed) {
    const GridMap map = random_map(23, 31, seed);
    const auto field = LikelihoodField::of(map, settings);
    ASSERT_TRUE(field.ok());
    for (std::int32_t row = 0; row < map.rows; ++row)
      for (std::int32_t column = 0; column < map.columns; ++column) {
        const double d = nearest(map, row, column) / settings.sigma;
        const double p = settings.hit * std::exp(-d * d / 2) + 1 - settings.hit;
        const double expected = 255 * (1 - std::log(p) / std::log(1 - settings.hit));
        EXPECT_NEAR(field->at(middle(-1000, row), middle(2000, column)), expected, 0.51);
      }
  }
}

TEST(LikelihoodField, GivesTheDistanceToTheNearestWall) {
  GridMap map{.rows = 10, .columns = 40};
  map.cells.assign(400, Cell::kFree);
  for (std::size_t row = 0; row < 10; ++row) map.cells[row * 40] = Cell::kOccupied;
  const auto field = LikelihoodField::of(map, {});
  ASSERT_TRUE(field.ok());
  EXPECT_NEAR(field->distance(200, 25), 0, 1e-6);
  for (const double y : {75.0, 125.0, 175.0, 225.0, 275.0})
    EXPECT_NEAR(field->distance(200, y), y - 25, 6) << y;
  EXPECT_GT(field->distance(200, 1500), 300);
}

// How far beside the wall, to its right, beams seem to end best: the middle of what they fit.
double off_beside(const LikelihoodField& field, const MapLine& wall) {
  const double length = std::hypot(wall.to.x - wall.from.x, wall.to.y - wall.from.y);
  const double ax = (wall.to.x - wall.from.x) / length;
  const double ay = (wall.to.y - wall.from.y) / length;
  double sum = 0;
  double all = 0;
  for (double along = 600; along < length - 600; along += 7)
    for (double beside = -397.5; beside < 400; beside += 5) {
      const double x = wall.from.x + along * ax - beside * ay;
      const double y = wall.from.y + along * ay + beside * ax;
      const double fits = field.at(static_cast<float>(x), static_cast<float>(y));
      sum += fits * beside;
      all += fits;
    }
  return sum / all;
}

TEST(LikelihoodField, AWallOfAPlanIsWhereItIsInItsCells) {
  for (const double turned : {0.0, 0.1, 0.5, kPi / 4, 1.0, kPi / 2, 2.0, kPi, 4.0, 5.5})
    for (const double within : {0.0, 10.0, 25.0, 40.0}) {  // of a cell
      const MapLine wall{
          {4000 + within, 4000 + within},
          {4000 + within + 2500 * std::cos(turned), 4000 + within + 2500 * std::sin(turned)}};
      // Cells are where the others are.
      const std::vector<MapLine> walls{
          {{0, 0}, {9000, 0}}, {{9000, 0}, {9000, 9000}}, {{0, 0}, {0, 9000}}, wall};
      const auto map = draw_walls(walls, 50);
      ASSERT_TRUE(map.ok());
      const auto field = LikelihoodField::of(*map, {});
      ASSERT_TRUE(field.ok());
      EXPECT_NEAR(off_beside(*field, wall), 0, 1) << turned << " " << within;
    }
}

TEST(LikelihoodField, ThePlanGivesTheDistanceToTheNearestWall) {
  const std::vector<MapLine> walls{{{0, 0}, {3000, 0}}, {{1013, 0}, {1013, 2000}}};
  const auto map = draw_walls(walls, 50);
  ASSERT_TRUE(map.ok());
  const auto field = LikelihoodField::of(*map, {});
  ASSERT_TRUE(field.ok());
  for (const double off : {-300.0, -200.0, -100.0, 100.0, 200.0, 300.0})  // to within half a cell
    EXPECT_NEAR(field->distance(1013 + off, 1500), std::abs(off), 28) << off;
  EXPECT_NEAR(field->distance(1013, 2200), 200, 28) << "beyond its end";
}

TEST(LikelihoodField, TheSumIsThatOfItsBeams) {
  const GridMap map = random_map(60, 80, 5);
  const auto field = LikelihoodField::of(map, {});
  ASSERT_TRUE(field.ok());
  Random random(9);
  for (const std::size_t count : {0U, 1U, 3U, 63U, 64U, 65U, 200U}) {
    Beams beams;
    for (std::size_t i = 0; i < count; ++i)
      beams.add({random.uniform(-4000, 4000), random.uniform(-4000, 4000)});
    const float rho = random.uniform(0, 6);
    const float s = std::sin(rho);
    const float c = std::cos(rho);
    int expected = 0;
    for (std::size_t i = 0; i < count; ++i)
      expected +=
          field->at(500 + c * beams[i].x - s * beams[i].y, 4000 + s * beams[i].x + c * beams[i].y);
    // Rounding may take the neighbouring cell now and then.
    EXPECT_NEAR(static_cast<int>(field->sum(500, 4000, s, c, beams)), expected, 120) << count;
  }
}

// More cells than a float can count.
TEST(LikelihoodField, AHugeMapIsExactToItsLastCell) {
  GridMap map{.origin = {}, .rows = 4100, .columns = 4101};
  map.cells.assign(4100UL * 4101, Cell::kUnknown);
  map.cells[0] = Cell::kFree;
  for (std::size_t column = 4001; column < 4101; column += 2)
    map.cells[4099UL * 4101 + column] = Cell::kOccupied;
  const auto field = LikelihoodField::of(map, {.sigma = 10});
  ASSERT_TRUE(field.ok());
  Beams beams;
  for (std::int32_t column = 4001; column < 4101; column += 2)
    beams.add({middle(0, 4099), middle(0, column)});
  EXPECT_EQ(field->sum(0, 0, 0, 1, beams), 255 * beams.size());
  EXPECT_LT(field->sum(0, 50, 0, 1, beams), 10 * beams.size()) << "the cells between";
}

TEST(LikelihoodField, BeyondTheMapNothingFits) {
  const GridMap map = random_map(10, 10, 1);
  const auto field = LikelihoodField::of(map, {});
  ASSERT_TRUE(field.ok());
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kEndless = std::numeric_limits<float>::infinity();
  for (const float far : {-1e9F, 1e9F, kEndless, -kEndless, kNan})
    for (const float other : {far, -1000.0F}) {
      EXPECT_EQ(field->at(far, other), 0) << far << " " << other;
      EXPECT_FALSE(field->is_free(static_cast<double>(far), static_cast<double>(other)));
      Beams beams;
      beams.add({far, other});
      EXPECT_EQ(field->sum(0, 2000, 0, 1, beams), 0U) << far << " " << other;
    }
}

TEST(LikelihoodField, RefusesMapsWithoutWallsOrWithoutRoom) {
  GridMap map{.rows = 2, .columns = 2};
  map.cells.assign(4, Cell::kFree);
  EXPECT_EQ(LikelihoodField::of(map, {}).error().detail(), "the map has no occupied cell");
  map.cells.assign(4, Cell::kOccupied);
  EXPECT_EQ(LikelihoodField::of(map, {}).error().detail(), "the map has no free cell");
  EXPECT_FALSE(LikelihoodField::of({}, {}).ok());
}

TEST(LikelihoodField, DrawsFreePlaces) {
  const GridMap map = random_map(20, 30, 3);
  const auto field = LikelihoodField::of(map, {});
  ASSERT_TRUE(field.ok());
  EXPECT_EQ(field->free_cells(), map.count(Cell::kFree));
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const MapPoint at = field->draw_free(random);
    EXPECT_TRUE(field->is_free(at.x, at.y));
  }
}

TEST(LikelihoodField, KnowsWhatIsBehindAWall) {
  GridMap map{.resolution = 50, .rows = 100, .columns = 100};
  map.cells.assign(10000, Cell::kFree);
  for (std::size_t column = 0; column < 100; ++column) map.cells[6000 + column] = Cell::kOccupied;
  const auto field = LikelihoodField::of(map, {});
  ASSERT_TRUE(field.ok());
  const Pose pose{.x = 1025, .y = 2525};  // the wall is 2 m ahead
  const auto blocked = [&](std::initializer_list<BeamEnd> ends) {
    Beams beams;
    for (const BeamEnd& end : ends) beams.add(end);
    return field->blocked(pose, beams);
  };
  EXPECT_EQ(blocked({}), 0);
  EXPECT_EQ(blocked({{2000, 0}}), 0) << "its end";
  EXPECT_EQ(blocked({{1000, 0}}), 0) << "somebody before it";
  EXPECT_EQ(blocked({{2400, 0}}), 0) << "as a wall at a low angle";
  EXPECT_EQ(blocked({{2700, 0}}), 1);
  EXPECT_EQ(blocked({{2700, 0}, {1000, 0}, {2000, 0}, {1000, 1000}}), 0.25);
  EXPECT_EQ(blocked({{2700, 900}, {1e9F, 0}}), 1);
  EXPECT_EQ(blocked({{0, 0}}), 0);
  EXPECT_EQ(blocked({{-1e30F, 1e30F}}), 0) << "the beam is only checked within the map";
}

TEST(Random, IsTheSameFromTheSameSeed) {
  EXPECT_EQ(Random(1234567).bits(), 6457827717110365317U);  // as published for SplitMix64
  Random random(1);
  double sum = 0;
  double squares = 0;
  constexpr int kCount = 100000;
  for (int i = 0; i < kCount; ++i) {
    const auto value = static_cast<double>(random.normal());
    sum += value;
    squares += value * value;
    const float part = random.uniform();
    EXPECT_TRUE(part >= 0 && part < 1);
    EXPECT_LT(random.below(7), 7U);
  }
  EXPECT_NEAR(sum / kCount, 0, 0.01);
  EXPECT_NEAR(squares / kCount, 1, 0.01);
}

}  // namespace likelihood_field_test

}  // namespace rack::localisation
