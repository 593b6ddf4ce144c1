// Drives along walls continuously (specification, section 10.7). Pure.
//
// The nearest point of a scan represents the wall: the ray to it meets the wall at a right angle.
// So its bearing gives the orientation of the vehicle to the wall, and its range the distance. The
// controller turns in proportion to the deviation from a right angle, plus an angle towards or away
// from the wall that grows with the distance error up to 30 degrees: a distant wall is approached
// steeply, near it the vehicle drives parallel.
//
// Two modes choose the wall. The geometric one keeps it on the right. The Braitenberg mode, named
// after vehicles that steer by what is near, follows the nearer side, or the middle between two,
// and keeps its choice until another wall is nearer. When the distance ahead (drive.h) is not free,
// the vehicle turns at rest, to the side where the corners of the hull have room.
#pragma once

#include <chrono>
#include <optional>

#include "components/pilot/drive.h"

namespace rack::pilot {

struct WallFollowerSettings {
  enum class Mode : std::uint8_t {
    kGeometric = 0,    // keeps the wall on its right at a distance
    kBraitenberg = 1,  // along the nearest wall, or between two; turns away from obstacles
  };
  Mode mode = Mode::kBraitenberg;
  i32 speed_max = 500;       // mm/s
  double omega_max = 0.35;   // rad/s
  i32 distance = 1000;       // to the wall, mm
  i32 test_distance = 1000;  // kBraitenberg: free distance required ahead, mm
};

class WallFollower {
 public:
  WallFollower(const WallFollowerSettings& settings, const ChassisParamData& chassis)
      : settings_(settings), chassis_(chassis) {}

  // Whether the next follow() needs the heading.
  [[nodiscard]] bool turns() const { return task_ == Task::kTurn; }

  // `period`: since the last scan. `heading`: rad, of the vehicle; used only during a turn.
  Drive follow(const Scan2dData& scan, std::chrono::milliseconds period, double heading = 0);

 private:
  enum class Task : std::uint8_t {
    kDrive,
    kTurn,  // at rest
  };
  enum class Wall : std::uint8_t { kNone, kRight, kLeft, kBoth };  // that the vehicle follows
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
  std::optional<Turn> turn_;           // in progress
  std::optional<double> turn_wanted_;  // requested angle; nullopt: chosen from the scan
  Wall wall_ = Wall::kNone;
  bool chooses_ = true;  // chooses a wall again, even if the current one could be kept
  i32 speed_ = 0;        // of the last scan
};

}  // namespace rack::pilot
