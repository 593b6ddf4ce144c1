// A minimal pilot as a starting point for your own: it turns to the destination, drives straight to
// it, and turns to the final heading. It does not avoid obstacles, but waits for them to clear.
// Pure.
//
// The settings are the parameters of the original's PilotLab, in which they have no effect until
// students write the states. Here each has one.
#pragma once

#include <optional>

#include "components/geometry/pose.h"
#include "components/pilot/drive.h"

namespace rack::pilot {

struct LabCourseSettings {
  i32 speed_max = 300;                 // mm/s
  i32 side_speed_max = 0;              // mm/s; above 0: drives sideways, too, where the chassis can
  double omega_max = radians(30);      // rad/s
  i32 slow_distance = 1000;            // mm: from here to the destination it becomes slower
  double heading_error = radians(15);  // drives when its heading is as near to the destination
  i32 obstacle_distance = 300;         // mm: stops so far from what is ahead
};

class LabCourse {
 public:
  enum class State : std::uint8_t { kIdle, kTurnThere, kDrive, kTurnAsItShallStand };

  LabCourse(const LabCourseSettings& settings, const ChassisParamData& chassis);

  void set_destination(const PilotDestData& destination);
  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] const PilotDestData& destination() const { return destination_; }
  // mm; -1: none.
  [[nodiscard]] double distance(const Pose& at) const;

  // The next command.
  Drive go(const Pose& at, const Scan2dData& scan);

 private:
  [[nodiscard]] Drive turn(double missing) const;
  [[nodiscard]] Drive drive(double left, double missing, const Scan2dData& scan) const;

  LabCourseSettings settings_;
  ChassisParamData chassis_;
  PilotDestData destination_;
  bool sent_ = false;
  State state_ = State::kIdle;
};

}  // namespace rack::pilot
