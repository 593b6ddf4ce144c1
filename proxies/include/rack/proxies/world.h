// A simulated world: its true state, and commands to change it (components/world). The original
// RACK has no such class.
#pragma once

#include <string>
#include <string_view>

#include "rack/proxies/geometry.h"
#include "rack/proxies/proxy.h"

namespace rack {

// Class number in addresses: above those of the original, below those of user-defined classes.
inline constexpr u32 kWorld = 0x7F;

struct WorldType {
  enum : i8 {
    kPlace = kFirstCommand,  // WorldPlace
    kPut,                    // WorldObstacle; answered by kObstacle: the same with its number
    kRemove,                 // WorldRemove
    kPeople,                 // WorldPeople
    kPlug,                   // WorldPlug
    kGetLines,               // answered by kLines
    kObstacle = -kFirstCommand,
    kLines = -kFirstCommand - 1,
  };
};

using WorldName = Text<32>;

namespace world_thing {
inline constexpr i32 kRobot = 0;
inline constexpr i32 kPerson = 1;
inline constexpr i32 kObstacle = 2;  // put there by a command
}  // namespace world_thing

// A robot, a person or an obstacle. x points north, y east.
struct WorldThing {
  i32 kind = world_thing::kRobot;
  i32 id = 0;           // robots and people count from 0; obstacle numbers are never reused
  WorldName name = {};  // of robots
  Position2d pos = {};
  // Speed over ground: of robots forward and to the right, of people to the north and to the east.
  MillimetresPerSecond<i32> vx = 0;
  MillimetresPerSecond<i32> vy = 0;
  RadiansPerSecond<f32> omega = 0;
  Millimetres<i32> radius = 0;     // of obstacles
  Millimetres<i32> travelled = 0;  // of robots: distance driven since the world was turned on
  i32 isBlocked = 0;               // 1: it is pushing against something
  // Number of contacts of a robot, by what it touched; `bumped`: people who walked into it.
  u32 walls = 0;
  u32 obstacles = 0;
  u32 people = 0;
  u32 robots = 0;
  u32 bumped = 0;

  // Contacts that the robot caused.
  [[nodiscard]] u32 contacts() const { return walls + obstacles + people + robots; }
};

// The true state at one moment: robots, then people, then obstacles.
struct WorldData {
  TimeStamp recordingTime = 0;
  i32 peopleMove = 1;  // 0: they do not move
  Count thingNum = {};
  Sequence<WorldThing, 512> things = {};

  [[nodiscard]] const WorldThing* find(i32 kind, std::string_view name) const {
    for (const WorldThing& thing : things)
      if (thing.kind == kind && thing.name.view() == name) return &thing;
    return nullptr;
  }
};

struct WorldPlace {
  WorldName robot = {};
  Position2d pos = {};
};

// A cylindrical obstacle.
struct WorldObstacle {
  i32 id = 0;  // valid in the answer
  Point2d pos = {};
  Millimetres<i32> radius = 250;
  Millimetres<i32> height = 1000;
};

struct WorldRemove {
  i32 id = 0;
};

struct WorldPeople {
  i32 move = 1;  // 0: they stop until the next command
};

struct WorldPlug {
  WorldName robot = {};
  WorldName sensor = {};  // "base": its drive
  i32 isPlugged = 1;      // 0: disconnected
};

// A device of a robot, and the port where its driver finds it.
struct WorldLine {
  WorldName robot = {};
  WorldName sensor = {};
  WorldName device = {};  // as named by rack-emulate
  Text<128> line = {};
  i32 isPlugged = 0;
};

struct WorldLines {
  Count lineNum = {};
  Sequence<WorldLine, 128> lines = {};
};

class WorldProxy : public DataProxy<WorldData, kWorld> {
 public:
  using DataProxy::DataProxy;

  Result<void> place(std::string_view robot, const Position2d& pos) {
    WorldPlace request{.pos = pos};
    if (!request.robot.assign(robot)) return nobody(robot);
    return command(WorldType::kPlace, request);
  }
  // The answer contains its number.
  Result<WorldObstacle> put(const WorldObstacle& obstacle) {
    return query<WorldObstacle>(WorldType::kPut, obstacle, WorldType::kObstacle);
  }
  Result<void> remove(i32 id) { return command(WorldType::kRemove, WorldRemove{id}); }
  Result<void> let_people_move(bool move) {
    return command(WorldType::kPeople, WorldPeople{move ? 1 : 0});
  }
  Result<void> plug(std::string_view robot, std::string_view sensor, bool is_plugged) {
    WorldPlug request{.isPlugged = is_plugged ? 1 : 0};
    if (!request.robot.assign(robot)) return nobody(robot);
    if (!request.sensor.assign(sensor)) return nobody(sensor);
    return command(WorldType::kPlug, request);
  }
  Result<WorldLines> get_lines() {
    return query<WorldLines>(WorldType::kGetLines, WorldType::kLines);
  }

 private:
  static tims::Error nobody(std::string_view name) {
    return {tims::Errc::kInvalidArgument,
            "\"" + std::string(name) + "\" is too long for a name in a world"};
  }
};

}  // namespace rack
