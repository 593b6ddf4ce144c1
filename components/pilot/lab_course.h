// The simplest pilot that gets somewhere, to begin one's own with: it turns to the place, drives
// there straight ahead, and turns as it shall stand. It goes round nothing, but waits before it.
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

  // What it does next.
  Drive go(const Pose& at, const Scan2dData& scan);

 private:
  [[nodiscard]] Drive turn(double missing) const;

  ChassisParamData chassis_;
  PilotDestData destination_;
  bool sent_ = false;
  State state_ = State::kIdle;
};

}  // namespace rack::pilot
