// A minimal pilot as a starting point for your own: it turns to the destination, drives straight to
// it, and turns to the final heading. It does not avoid obstacles, but waits for them to clear.
// Pure.
#pragma once

#include <optional>

#include "components/geometry/pose.h"
#include "components/pilot/drive.h"

namespace rack::pilot {

class LabCourse {
 public:
  enum class State : std::uint8_t { kIdle, kTurnThere, kDrive, kTurnAsItShallStand };

  explicit LabCourse(const ChassisParamData& chassis) : chassis_(chassis) {}

  void set_destination(const PilotDestData& destination);
  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] const PilotDestData& destination() const { return destination_; }
  // mm; -1: none.
  [[nodiscard]] double distance(const Pose& at) const;

  // The next command.
  Drive go(const Pose& at, const Scan2dData& scan);

 private:
  [[nodiscard]] Drive turn(double missing) const;

  ChassisParamData chassis_;
  PilotDestData destination_;
  bool sent_ = false;
  State state_ = State::kIdle;
};

}  // namespace rack::pilot
