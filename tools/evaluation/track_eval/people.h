// A hall with people and a robot, to judge how well people are followed: what its scanner sees, and
// where everybody truly is. Pure.
//
// The hall is 16 m x 12 m, with pillars and a table. People walk straight to some place, stand
// there for a while, and go on; they stop before each other and before the robot. Each is seen as
// two legs: circles of 60 mm that swing as people stride. The robot goes round on an ellipse. Its
// ranges have noise, some beams nothing comes back of, and its odometry drifts, unless it has a map
// and knows where it is but for some noise.
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
  double dropped = 0.005;    // share of beams
  double robot_speed = 500;  // mm/s
  bool localised = false;    // it knows where it is
};

struct Person {
  MapPoint at{};
  MapPoint velocity{};      // mm/s
  std::uint32_t beams = 0;  // of the last scan, that met one of its legs
};

class Hall {
 public:
  explicit Hall(const HallSettings& settings);

  // As it stands on paper, in m.
  static DxfDrawing plan();

  // A period later.
  void step();
  void scan(Scan2dData& scan);
  [[nodiscard]] PositionData position() const;  // as the robot knows it

  [[nodiscard]] const std::vector<Person>& people() const { return people_; }
  [[nodiscard]] const Pose& robot() const { return robot_; }

 private:
  struct Walk {
    MapPoint goal{};
    double wanted = 1200;  // mm/s
    double speed = 0;
    double direction = 0;
    double phase = 0;  // of the stride
    double rest = 0;   // s
    double waits = 0;  // s, for somebody in the way
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
  std::vector<std::size_t> met_;  // whose leg a beam ends at
  Pose robot_{};
  Pose odometry_{};
  double way_ = 0;  // of the robot
  double now_ = 0;  // s
};

}  // namespace rack::track_eval
