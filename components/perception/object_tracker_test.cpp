#include "components/perception/object_tracker.h"

#include <vector>

#include <gtest/gtest.h>

namespace rack::perception {
namespace {

Cluster leg(double x, double y) {
  return {.box = {.centre = {x, y}, .length = 120, .width = 120},
          .away = 3000,
          .size = 120,
          .spacing = 20,
          .moved = 1,
          .count = 6,
          .leg = true,
          .person = true};
}

TEST(ObjectTracker, TwoLegsAreOnePerson) {
  ObjectTracker tracker({});
  for (int i = 0; i < 5; ++i)
    tracker.take(std::vector{leg(3000, i * 100.0 - 150), leg(3000, i * 100.0 + 150)}, {}, i * 0.1);
  ASSERT_EQ(tracker.tracks().size(), 1U);
  EXPECT_TRUE(tracker.tracks()[0].confirmed());
  EXPECT_EQ(tracker.tracks()[0].kind(), ObjectKind::kPedestrian);
}

TEST(ObjectTracker, TwoWhoPassEachOtherKeepTheirNumbers) {
  ObjectTracker tracker({});
  for (int i = 0; i < 40; ++i) {
    const double along = i * 100.0;
    tracker.take(std::vector{leg(3000, along - 100), leg(3000, along + 100),
                             leg(3800, 3900 - along), leg(3800, 4100 - along)},
                 {}, i * 0.1);
  }
  ASSERT_EQ(tracker.tracks().size(), 2U);
  EXPECT_LE(tracker.tracks()[1].id(), 2);
  EXPECT_NEAR(tracker.tracks()[0].at().y, 3900, 100);
  EXPECT_NEAR(tracker.tracks()[1].at().y, 100, 100);
}

TEST(ObjectTracker, WhatStoodThereBeforeIsNotWhoComes) {
  ObjectTracker tracker({});
  for (int i = 0; i < 30; ++i) tracker.take(std::vector{leg(3000, i * 100.0)}, {}, i * 0.1);
  ASSERT_EQ(tracker.tracks().size(), 1U);
  Cluster pillar = leg(3000, 3100);
  pillar.moved = 0;
  pillar.stood = 5;
  for (int i = 30; i < 45; ++i) tracker.take(std::vector{pillar}, {}, i * 0.1);
  EXPECT_TRUE(tracker.tracks().empty());
}

// From one leg of a chair to the next: beams meet now this, now that one.
TEST(ObjectTracker, WhatTakesItsNeighboursPlaceHasNotMoved) {
  for (const bool stays : {false, true}) {
    ObjectTracker tracker({});
    Cluster chair = leg(3000, 0);
    bool moving = false;
    for (int i = 0; i < 40; ++i) {
      std::vector<Cluster> seen{leg(3000, std::max(0, i - 10) * 80.0)};
      chair.moved = 0;
      if (stays && i > 15) seen.push_back(chair);
      tracker.take(seen, {}, i * 0.1);
      for (const Track& track : tracker.tracks()) moving = moving || track.moving();
    }
    EXPECT_EQ(moving, !stays);
  }
}

TEST(ObjectTracker, NothingBeginsWhereNothingMovedUnlessThereIsAMap) {
  Cluster still = leg(3000, 0);
  still.moved = 0;
  ObjectTracker without({.only_moved = true});
  ObjectTracker with({.only_moved = false});
  for (int i = 0; i < 5; ++i) {
    without.take(std::vector{still}, {}, i * 0.1);
    with.take(std::vector{still}, {}, i * 0.1);
  }
  EXPECT_TRUE(without.tracks().empty());
  EXPECT_EQ(with.tracks().size(), 1U);
  EXPECT_TRUE(with.stop(1));
  EXPECT_FALSE(with.stop(1));
}

TEST(ObjectTracker, MoreThanItHasRoomFor) {
  std::vector<Cluster> many;
  for (int i = 0; i < 900; ++i) many.push_back(leg(1000.0 * (i % 30), 1000.0 * (i / 30)));
  ObjectTracker tracker({});
  for (int i = 0; i < 10; ++i) tracker.take(many, {}, i * 0.1);
  EXPECT_EQ(tracker.tracks().size(), ObjectTracker::kTracksMax);
  tracker.take({}, {}, 1.0);
  tracker.take({}, {}, 2.5);
  EXPECT_TRUE(tracker.tracks().empty());
}

}  // namespace
}  // namespace rack::perception
