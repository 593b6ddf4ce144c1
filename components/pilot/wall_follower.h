// Drives along walls, on and on (specification, section 10.7). Pure.
//
// The nearest point of a scan stands for the wall it lies on: a ray to it meets the wall at right
// angles. So the bearing of this point tells how the vehicle lies to the wall, and its range how
// far it is. The controller turns in proportion to the angle that is missing to a right one, plus
// an angle towards the wall, or away from it, that grows with the error of the distance up to 30
// degrees: far from the wall it is approached steeply, near it the vehicle runs parallel.
//
// Two modes choose the wall. The geometric one keeps it on the right. The one called after
// Braitenberg, whose vehicles steer by what is near, takes the side that is near, the middle of
// two, and keeps its choice until another wall is nearer. Whatever does not leave room ahead
// (drive.h) ends in a turn at rest, to the side where the corners of the hull have room.
#pragma once

#include <chrono>
#include <optional>

#include "components/pilot/drive.h"

namespace rack::pilot {

struct WallFollowerSettings {
  enum class Mode : std::uint8_t {
    kGeometric = 0,    // keeps the wall on its right at a distance
    kBraitenberg = 1,  // along the wall that is near, and amid two; turns away from what is ahead
  };
  Mode mode = Mode::kBraitenberg;
  i32 speed_max = 500;       // mm/s
  double omega_max = 0.35;   // rad/s
  i32 distance = 1000;       // to the wall, mm
  i32 test_distance = 1000;  // kBraitenberg: what it wants free ahead of it, mm
};

class WallFollower {
 public:
  WallFollower(const WallFollowerSettings& settings, const ChassisParamData& chassis)
      : settings_(settings), chassis_(chassis) {}

  // Whether the next follow() has to know the heading.
  [[nodiscard]] bool turns() const { return task_ == Task::kTurn; }

  // `period`: since the last scan. `heading`: rad, of the vehicle, only while it turns.
  Drive follow(const Scan2dData& scan, std::chrono::milliseconds period, double heading = 0);

 private:
  enum class Task : std::uint8_t {
    kDrive,
    kTurn,  // at rest
  };
  enum class Wall : std::uint8_t { kNone, kRight, kLeft, kBoth };  // that it drives along
  struct Turn {
    double angle = 0;  // rad, clockwise
    double done = 0;
    double heading = 0;  // of the last scan
  };

  Drive drive(const Scan2dData& scan);
  Drive geometric(const Scan2dData& scan);
  Drive braitenberg(const Scan2dData& scan);
  void choose_wall(const Scan2dData& scan);
  [[nodiscard]] bool keeps_wall(const Scan2dData& scan) const;
  [[nodiscard]] double steer_along_wall(const Scan2dData& scan) const;
  Drive go(double omega, const Scan2dData& scan);
  Drive stop_and_turn(std::optional<double> angle = std::nullopt);
  Drive turn(const Scan2dData& scan, double heading);
  bool begin_turn(const Scan2dData& scan, double heading);
  [[nodiscard]] double angle_of_turn(const Scan2dData& scan);

  [[nodiscard]] double lateral(double range) const;
  [[nodiscard]] double clamp_omega(double omega) const;
  [[nodiscard]] i32 safe_straight(const Scan2dData& scan) const;
  [[nodiscard]] bool free_ahead(const Scan2dData& scan, double distance) const;
  [[nodiscard]] bool free_to_turn(const Scan2dData& scan, double angle, int margins) const;

  WallFollowerSettings settings_;
  ChassisParamData chassis_;
  Task task_ = Task::kDrive;
  std::optional<Turn> turn_;           // begun
  std::optional<double> turn_wanted_;  // instead of what it sees then
  Wall wall_ = Wall::kNone;
  bool chooses_ = true;  // another wall, whether it could keep this one or not
  i32 speed_ = 0;        // of the last scan
};

}  // namespace rack::pilot
