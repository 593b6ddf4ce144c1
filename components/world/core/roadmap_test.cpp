#include "components/world/core/roadmap.h"

#include <set>

#include <gtest/gtest.h>

#include "components/world/core/rooms_fixture.h"

namespace rack::world {
namespace roadmap_test {

TEST(Roadmap, LeadsFromPlaceToPlaceWithRoom) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Scenery scenery(two_rooms(), kTable);
    const Roadmap roadmap(scenery, kRooms, 290, seed);
    ASSERT_GT(roadmap.size(), 100U);
    std::set<bool> rooms;
    for (std::size_t from = 0; from < roadmap.size(); ++from) {
      rooms.insert(roadmap.place(from).y < 5000);
      for (std::size_t to = 0; to < roadmap.size(); to += 7) {
        std::size_t at = from;
        std::size_t legs = 0;
        while (at != to && legs < roadmap.size()) {
          const std::size_t next = roadmap.next(at, to);
          const MapPoint& a = roadmap.place(at);
          const MapPoint& b = roadmap.place(next);
          const MapPoint middle{(a.x + b.x) / 2, (a.y + b.y) / 2};
          ASSERT_GE(scenery.clearance(middle, 1000), 285);
          at = next;
          ++legs;
        }
        ASSERT_EQ(at, to);
      }
    }
    EXPECT_EQ(rooms.size(), 2U) << "nobody goes through the door, seed " << seed;
  }
}

TEST(Roadmap, OfNoRoomIsEmpty) {
  const Scenery scenery(two_rooms(), {});
  EXPECT_EQ(Roadmap(scenery, {{0, 0}, {200, 200}}, 290, 1).size(), 0U);
}

}  // namespace roadmap_test
}  // namespace rack::world
