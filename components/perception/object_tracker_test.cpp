#include "components/perception/object_tracker.h"

#include <vector>

#include <gtest/gtest.h>

#include "components/perception/room_fixture.h"

namespace rack::perception {
namespace object_tracker_test {

Cluster leg(double x, double y) {
  return {.box = {.centre = {x, y}, .length = 120, .width = 120},
          .point = {x, y},
          .away = 3000,
          .size = 120,
          .spacing = 20,
          .moved = 1,
          .count = 6,
          .leg = true,
          .person = true};
}

// In a bare room, where nothing else stands.
void take(ObjectTracker& tracker, const std::vector<Cluster>& clusters, double seconds) {
  Room world;
  std::vector<Room::Circle> things;
  things.reserve(clusters.size());
  for (const Cluster& cluster : clusters) things.push_back({.at = cluster.box.centre});
  tracker.take(clusters, {}, table_of(world.scan(things)), seconds);
}

TEST(ObjectTracker, TwoLegsAreOnePerson) {
  ObjectTracker tracker({});
  for (int i = 0; i < 5; ++i)
    take(tracker, std::vector{leg(3000, i * 100.0 - 150), leg(3000, i * 100.0 + 150)}, i * 0.1);
  ASSERT_EQ(tracker.tracks().size(), 1U);
  EXPECT_TRUE(tracker.tracks()[0].confirmed());
  EXPECT_EQ(tracker.tracks()[0].kind(), ObjectKind::kPedestrian);
}

TEST(ObjectTracker, TwoPeoplePassingEachOtherKeepTheirNumbers) {
  ObjectTracker tracker({});
  for (int i = 0; i < 40; ++i) {
    const double along = i * 100.0;
    take(tracker,
         std::vector{leg(3000, along - 100), leg(3000, along + 100), leg(3800, 3900 - along),
                     leg(3800, 4100 - along)},
         i * 0.1);
  }
  ASSERT_EQ(tracker.tracks().size(), 2U);
  EXPECT_LE(tracker.tracks()[1].id(), 2);
  EXPECT_NEAR(tracker.tracks()[0].at().y, 3900, 100);
  EXPECT_NEAR(tracker.tracks()[1].at().y, 100, 100);
}

TEST(ObjectTracker, AnObjectThatStoodThereBeforeDoesNotContinueATrack) {
  ObjectTracker tracker({});
  for (int i = 0; i < 30; ++i) take(tracker, std::vector{leg(3000, i * 100.0)}, i * 0.1);
  ASSERT_EQ(tracker.tracks().size(), 1U);
  Cluster pillar = leg(3000, 3100);
  pillar.moved = 0;
  pillar.stood = 5;
  for (int i = 30; i < 45; ++i) take(tracker, std::vector{pillar}, i * 0.1);
  EXPECT_TRUE(tracker.tracks().empty());
}

// Along the legs of a table: each is seen where the last one was not, and all of them stay.
TEST(ObjectTracker, WhatIsMetAgainWhereItWasHasNotMoved) {
  for (const bool stays : {false, true}) {
    ObjectTracker tracker({});
    Room world;
    bool moving = false;
    for (int i = 0; i < 40; ++i) {
      const Cluster seen = leg(3000, i * 60.0);
      std::vector<Room::Circle> things{{.at = seen.box.centre}};
      for (int n = 0; stays && n < i; n += 6) things.push_back({.at = {3000, n * 60.0}});
      tracker.take(std::vector{seen}, {}, table_of(world.scan(things)), i * 0.1);
      for (const Track& track : tracker.tracks()) moving = moving || track.moving();
    }
    EXPECT_EQ(moving, !stays);
  }
}

// A person who stands behind a pillar for 4 s keeps the number; one whose place is empty does not.
TEST(ObjectTracker, AHiddenObjectIsNotGone) {
  for (const bool hidden : {true, false}) {
    ObjectTracker tracker({});
    Room world;
    int i = 0;
    for (; i < 60; ++i) take(tracker, {leg(3000, std::min(i, 30) * 80.0)}, i * 0.1);
    ASSERT_EQ(tracker.tracks().size(), 1U);
    const std::int32_t id = tracker.tracks()[0].id();
    ASSERT_FALSE(tracker.tracks()[0].moving());
    std::vector<Room::Circle> things;
    if (hidden) things.push_back({.at = {1500, 1200}, .radius = 200});
    for (; i < 100; ++i) {
      tracker.take({}, {}, table_of(world.scan(things)), i * 0.1);
      for (const Track& track : tracker.tracks()) EXPECT_EQ(track.published(), i < 65) << i;
    }
    EXPECT_EQ(tracker.tracks().size(), hidden ? 1U : 0U);
    for (; i < 105; ++i) take(tracker, {leg(3000, 2400)}, i * 0.1);
    ASSERT_EQ(tracker.tracks().size(), 1U);
    EXPECT_EQ(tracker.tracks()[0].id() == id, hidden);
  }
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
      take(tracker, seen, i * 0.1);
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
    take(without, std::vector{still}, i * 0.1);
    take(with, std::vector{still}, i * 0.1);
  }
  EXPECT_TRUE(without.tracks().empty());
  EXPECT_EQ(with.tracks().size(), 1U);
  EXPECT_TRUE(with.stop(1));
  EXPECT_FALSE(with.stop(1));
}

TEST(ObjectTracker, MoreThanItHasRoomFor) {
  std::vector<Cluster> many;
  many.reserve(900);
  for (int x = 0; x < 30; ++x)
    for (int y = 0; y < 30; ++y) many.push_back(leg(1000.0 * x, 1000.0 * y));
  ObjectTracker tracker({});
  for (int i = 0; i < 10; ++i) tracker.take(many, {}, {}, i * 0.1);
  EXPECT_EQ(tracker.tracks().size(), ObjectTracker::kTracksMax);
  tracker.take({}, {}, {}, 1.0);
  tracker.take({}, {}, {}, 2.5);
  EXPECT_TRUE(tracker.tracks().empty());
}

}  // namespace object_tracker_test
}  // namespace rack::perception
