// Interface of the dialogues of all vehicles, and the control of the speed: the speed requested by
// the active pilot, within the limits of the vehicle, and 0 when the pilot stops sending.
//
// A vehicle must stop when its pilot crashes. A MOVE is therefore valid for three periods of the
// pilot, which are estimated from its MOVEs; then the speed is set to 0 at once. The same happens
// when another pilot becomes active. Otherwise accMax and decMax limit the change of speed.
#pragma once

#include "components/devices/chassis/move_deadline.h"
#include "components/geometry/wheels.h"
#include "rack/devices/dialogue.h"
#include "rack/proxies/chassis.h"

namespace rack::device {

class ChassisDialogue : public Dialogue {
 public:
  // Sets the speed; sent as soon as the protocol permits. Replaces an earlier speed that was not
  // yet sent.
  virtual void drive(const ChassisSpeed& speed, Time now) = 0;

  [[nodiscard]] virtual bool is_ready() const = 0;
  // Fills all fields except activePilot.
  virtual bool take(ChassisData& data, Time& recorded) = 0;
};

struct ChassisRules {
  // True for tracked vehicles and differential drives, false for steered vehicles.
  bool turns_on_the_spot = true;
  // Validity of a MOVE; 0: three periods of the pilot.
  Duration move_deadline{};
};

class ChassisControl {
 public:
  ChassisControl(const ChassisParamData& limits, const ChassisRules& rules)
      : limits_(limits), rules_(rules), deadline_(rules.move_deadline) {}

  [[nodiscard]] const ChassisParamData& limits() const { return limits_; }
  [[nodiscard]] tims::Address active_pilot() const { return pilot_; }
  void set_active_pilot(tims::Address pilot);  // also stops the vehicle

  // A MOVE of the active pilot. The request is limited to the maximum speeds; a speed below the
  // minimum is raised to the minimum.
  void move(const ChassisMoveData& target, Time now);

  // The speed to command now.
  ChassisSpeed speed(Time now);
  // When the result of speed() changes next.
  [[nodiscard]] Time next_change() const;
  // True once after each stop because the last MOVE had expired.
  bool take_overdue();
  [[nodiscard]] Duration deadline() const { return deadline_.length(); }

 private:
  void stop();

  ChassisParamData limits_;
  ChassisRules rules_;
  tims::Address pilot_ = kNoPilot;
  MoveDeadline deadline_;  // without a valid MOVE the vehicle stops
  ChassisSpeed wanted_;
  ChassisSpeed now_;
  Time stepped_{};  // last call of speed()
  bool overdue_ = false;
};

}  // namespace rack::device
