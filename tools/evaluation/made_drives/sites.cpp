#include "tools/evaluation/made_drives/sites.h"

#include <algorithm>
#include <span>

#include "components/geometry/random.h"

namespace rack::made_drives {

namespace {

constexpr double kWall = 0.2;  // m

double between_values(Random& random, double from, double to) {
  return from + (to - from) * static_cast<double>(random.uniform());
}

// --- laboratory

constexpr double kLaboratoryWidth = 54;
constexpr double kLaboratoryHeight = 34;
constexpr double kCorridor = 2.0;
constexpr double kRoomWidth = 4.0;
constexpr double kRoomDepth = 5.0;
constexpr double kDoor = 1.0;
constexpr double kSouth = 7;  // lower left corners of corridors
constexpr double kNorth = 25;
constexpr double kWest = 7;
constexpr double kMiddle = 25;
constexpr double kEast = 45;

struct Room {
  double x;
  double y;
  MapPoint door;    // middle, in the corridor in front of it
  MapPoint inside;  // where the robot turns
};

// A room behind the corridor that begins at `corridor`: to the north (up) or to the south.
Room carve_room(CarvedFloor& floor, double x, double corridor, bool up, Random& random) {
  const double y = up ? corridor + kCorridor + kWall : corridor - kWall - kRoomDepth;
  const double wall = up ? corridor + kCorridor : corridor - kWall;
  floor.carve(x + kWall / 2, y, x + kRoomWidth - kWall / 2, y + kRoomDepth);
  const double door = x + (random.below(2) == 0 ? 0.6 : kRoomWidth - kDoor - 0.6);
  floor.carve(door, wall - 0.05, door + kDoor, wall + kWall + 0.05);
  // Desks along the far wall and the sides, as everywhere.
  const double far = up ? y + kRoomDepth - 0.8 : y;
  floor.put(x + between_values(random, 0.2, 0.9), far, x + between_values(random, 1.6, 3.4),
            far + 0.8);
  if (random.below(3) != 0) {
    const double side = door < x + 2 ? x + kRoomWidth - 0.7 : x + kWall / 2;
    const double at = y + between_values(random, 0.5, 2.5);
    floor.put(side, at, side + 0.6, at + between_values(random, 0.5, 1.5));
  }
  const double middle = door + kDoor / 2;
  return {x, y, {middle, corridor + kCorridor / 2}, {middle, up ? y + 1.8 : y + kRoomDepth - 1.8}};
}

// A side of a ring, with visits of some rooms; `along`: from its begin to its end.
void drive_side(std::span<const Room> rooms, double from, double to, std::size_t visit_every,
                Random& random, std::vector<MapPoint>& route) {
  std::vector<const Room*> on_the_way;
  for (const Room& room : rooms)
    if (room.door.x > std::min(from, to) + 1 && room.door.x < std::max(from, to) - 1)
      on_the_way.push_back(&room);
  if (from > to) std::ranges::reverse(on_the_way);
  for (const Room* room : on_the_way) {
    if (visit_every == 0 || random.below(static_cast<std::uint32_t>(visit_every)) != 0) continue;
    route.push_back(room->door);
    route.push_back(room->inside);
    route.push_back(room->door);
  }
}

}  // namespace

Site laboratory(std::uint64_t seed) {
  Site site{CarvedFloor(kLaboratoryWidth, kLaboratoryHeight)};
  CarvedFloor& floor = site.floor;
  Random random(seed);
  const double end = kEast + kCorridor;
  floor.carve(kWest, kSouth, end, kSouth + kCorridor);
  floor.carve(kWest, kNorth, end, kNorth + kCorridor);
  for (const double x : {kWest, kMiddle, kEast})
    floor.carve(x, kSouth, x + kCorridor, kNorth + kCorridor);
  std::vector<Room> south;
  std::vector<Room> north;
  for (const double begin : {kWest + kCorridor + kWall, kMiddle + kCorridor + kWall})
    for (double x = begin; x + kRoomWidth < begin + kMiddle - kWest - kCorridor; x += kRoomWidth)
      for (const bool up : {false, true}) {
        south.push_back(carve_room(floor, x, kSouth, up, random));
        north.push_back(carve_room(floor, x, kNorth, up, random));
      }
  const auto by_door = [](const Room& a, const Room& b) { return a.door.x < b.door.x; };
  std::ranges::sort(south, by_door);
  std::ranges::sort(north, by_door);
  const double half = kCorridor / 2;
  const double low = kSouth + half;
  const double high = kNorth + half;
  const auto west = kWest + half;
  const auto middle = kMiddle + half;
  const auto east = kEast + half;
  auto& route = site.route;
  const auto go = [&](double x, double y, std::size_t visit_every) {
    const MapPoint last = route.back();
    if (last.y == y) drive_side(y == low ? south : north, last.x, x, visit_every, random, route);
    route.push_back({x, y});
  };
  route.push_back({middle + 1, low});
  // The small ring, the large one around both, the other small one the other way, and again.
  go(west, low, 4), go(west, high, 0), go(middle, high, 4), go(middle, low, 0);
  go(east, low, 4), go(east, high, 0), go(west, high, 4), go(west, low, 0);
  go(middle, low, 0), go(middle, high, 0), go(east, high, 5), go(east, low, 0);
  go(middle, low, 6), go(middle, high, 0), go(west, high, 6), go(west, low, 0), go(middle, low, 0);
  return site;
}

// --- campus

namespace {

constexpr double kCampusWidth = 270;
constexpr double kCampusHeight = 150;
constexpr double kHall = 2.6;        // m, width of a corridor
constexpr double kDoorsEvery = 5.0;  // m

void doors(CarvedFloor& floor, double x, double y, double length, bool east, Random& random) {
  for (double at = kDoorsEvery; at + 2 < length; at += kDoorsEvery) {
    const double deep = 0.2;
    for (const bool far : {false, true}) {
      const double beside = far ? kHall : -deep;
      if (east) floor.carve(x + at, y + beside, x + at + 1, y + beside + deep);
      if (!east) floor.carve(x + beside, y + at, x + beside + deep, y + at + 1);
    }
    if (random.below(6) != 0) continue;
    // A niche, or a cupboard: what tells one part of a corridor from another.
    const double depth = between_values(random, 0.3, 1.5);
    const double wide = between_values(random, 0.5, 2.5);
    const double begin = at + between_values(random, 1.2, 2.0);
    const bool far = random.below(2) == 0;
    const double beside = far ? kHall : -depth;
    if (east) floor.carve(x + begin, y + beside, x + begin + wide, y + beside + depth);
    if (!east) floor.carve(x + beside, y + begin, x + beside + depth, y + begin + wide);
  }
}

}  // namespace

Site campus(std::uint64_t seed) {
  Site site{CarvedFloor(kCampusWidth, kCampusHeight)};
  CarvedFloor& floor = site.floor;
  Random random(seed);
  constexpr double kLeft = 8;
  constexpr double kBottom = 8;
  constexpr double kLength = 250;
  constexpr double kRise = 60;
  constexpr double kInner = 90;  // x of the inner corridors
  constexpr double kInnerEast = 180;
  const auto hall = [&](double x, double y, double length, bool east) {
    if (east) floor.carve(x, y, x + length, y + kHall);
    if (!east) floor.carve(x, y, x + kHall, y + length);
    doors(floor, x, y, length, east, random);
  };
  hall(kLeft, kBottom + kRise, kLength + kHall, true);  // the long one
  hall(kLeft, kBottom, kInner + kHall, true);
  hall(kLeft, kBottom, kRise + kHall, false);
  hall(kLeft + kInner, kBottom, 2 * kRise + kHall, false);
  hall(kLeft + kInnerEast, kBottom + kRise, kRise + kHall, false);
  hall(kLeft + kInner, kBottom + 2 * kRise, kLength - kInner + kHall, true);
  hall(kLeft + kLength, kBottom + kRise, kRise + kHall, false);
  constexpr double kMiddle = kHall / 2;
  const auto add = [&](double x, double y) {
    site.route.push_back({kLeft + kMiddle + x, kBottom + kMiddle + y});
  };
  add(20, kRise);
  add(kLength, kRise);  // the long corridor
  add(kLength, 2 * kRise);
  add(kInner, 2 * kRise);
  add(kInner, 0);
  add(0, 0);
  add(0, kRise);
  add(kLength, kRise);  // again
  add(kLength, 2 * kRise);
  add(kInnerEast, 2 * kRise);
  add(kInnerEast, kRise);
  add(0, kRise);  // back along most of it
  add(0, 0);
  add(kInner, 0);
  add(kInner, 2 * kRise);
  add(kInnerEast, 2 * kRise);
  add(kInnerEast, kRise);
  add(kInner, kRise);
  return site;
}

}  // namespace rack::made_drives
