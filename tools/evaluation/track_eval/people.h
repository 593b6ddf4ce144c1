// A simulated hall with people and a robot, for the evaluation of people tracking: scans of the
// robot and the true positions. Pure.
//
// The hall is 16 m x 12 m, with pillars and a table. People walk straight to a random place, stand
// there for a while, and continue; they stop in front of each other and of the robot. Each person
// is two legs: circles of 60 mm that swing with the stride. The robot drives on an ellipse. Its
// ranges have noise, some beams return no echo, and its odometry drifts; a localised robot has only
// small position noise.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "components/geometry/floor_map.h"
#include "components/geometry/pose.h"
#include "components/geometry/random.h"
#include "rack/proxies/position.h"
#include "rack/proxies/scan2d.h"

namespace rack::track_eval {

struct HallSettings {
  std::uint64_t seed = 1;
  std::uint32_t people = 6;
  std::uint32_t beams = 361;
  double opening = 360;      // deg, of the scanner
  double period = 0.1;       // s
  double range_max = 20000;  // mm
  double noise = 15;         // mm
  double dropped = 0.005;    // fraction of beams
  double robot_speed = 500;  // mm/s
  bool localised = false;    // the robot knows its pose
};

struct Person {
  MapPoint at{};
  MapPoint velocity{};      // mm/s
  std::uint32_t beams = 0;  // beams of the last scan that hit one of its legs
};

class Hall {
 public:
  explicit Hall(const HallSettings& settings);

  // The floor plan, in m.
  static DxfDrawing plan();

  // Advances by one period.
  void step();
  void scan(Scan2dData& scan);
  [[nodiscard]] PositionData position() const;  // as estimated by the robot

  [[nodiscard]] const std::vector<Person>& people() const { return people_; }
  [[nodiscard]] const Pose& robot() const { return robot_; }

 private:
  struct Walk {
    MapPoint goal{};
    double wanted = 1200;  // mm/s
    double speed = 0;
    double direction = 0;
    double phase = 0;  // phase of the stride
    double rest = 0;   // s
    double waits = 0;  // waiting time in front of an obstacle, s
  };
  struct Leg {
    MapPoint at{};
    std::size_t person = 0;
  };
  void move_robot(double seconds);
  void move_person(std::size_t i, double seconds);
  [[nodiscard]] bool is_free(const MapPoint& from, const MapPoint& to) const;
  [[nodiscard]] bool meets(std::size_t i, const MapPoint& next) const;
  [[nodiscard]] MapPoint somewhere();
  void choose_goal(Walk& walk, const MapPoint& from);
  void place_legs();
  void cast_legs(double first, double step);

  HallSettings settings_;
  FloorMap walls_;
  Random random_;
  std::vector<Person> people_;
  std::vector<Walk> walks_;
  std::vector<Leg> legs_;
  std::vector<double> ranges_;
  std::vector<std::size_t> met_;  // index of the leg that a beam hits
  Pose robot_{};
  Pose odometry_{};
  double travelled_ = 0;  // distance driven by the robot
  double now_ = 0;        // s
};

}  // namespace rack::track_eval
