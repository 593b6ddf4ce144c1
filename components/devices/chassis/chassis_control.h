// How a chassis driver talks with its vehicle, whichever it is, and what it lets its wheels do: the
// speed that the active pilot wants, within the limits of the vehicle, and nothing once the pilot
// is silent.
//
// A vehicle whose pilot has died must not go on. So a MOVE holds for three periods of the pilot
// that sent it, which are learnt from its MOVEs, and then the speed becomes 0 at once. It also does
// when another pilot becomes the active one. In between the speed changes as accMax and decMax
// allow.
#pragma once

#include "components/devices/chassis/move_deadline.h"
#include "components/devices/core/dialogue.h"
#include "components/geometry/wheels.h"
#include "rack/proxies/chassis.h"

namespace rack::device {

class ChassisDialogue : public Dialogue {
 public:
  // From now on; sent as soon as the device may be told. What was wanted before is forgotten.
  virtual void drive(const ChassisSpeed& speed, Time now) = 0;

  [[nodiscard]] virtual bool is_ready() const = 0;
  // All but the active pilot.
  virtual bool take(ChassisData& data, Time& recorded) = 0;
};

struct ChassisRules {
  // Whether it can turn without going: tracks and differential drives can, steered vehicles not.
  bool turns_on_the_spot = true;
  // How long a MOVE holds; 0: three periods of the pilot.
  Duration move_deadline{};
};

class ChassisControl {
 public:
  ChassisControl(const ChassisParamData& limits, const ChassisRules& rules)
      : limits_(limits), rules_(rules), deadline_(rules.move_deadline) {}

  [[nodiscard]] const ChassisParamData& limits() const { return limits_; }
  [[nodiscard]] tims::Address active_pilot() const { return pilot_; }
  void set_active_pilot(tims::Address pilot);  // also stops

  // Of the active pilot. The wish is cut to what the vehicle can do; a speed below the smallest
  // becomes the smallest.
  void move(const ChassisMoveData& wish, Time now);

  // What the wheels shall do now.
  ChassisSpeed speed(Time now);
  // When speed() is another one than it was.
  [[nodiscard]] Time next_change() const;
  // The last wish was too old: the vehicle was stopped. True once for each time.
  bool take_overdue();
  [[nodiscard]] Duration deadline() const { return deadline_.length(); }

 private:
  void stop();
  [[nodiscard]] ChassisSpeed within_limits(const ChassisMoveData& wish) const;
  [[nodiscard]] float approach(float from, float to, float acceleration, float deceleration,
                               float seconds) const;

  ChassisParamData limits_;
  ChassisRules rules_;
  tims::Address pilot_ = kNoPilot;
  MoveDeadline deadline_;  // while it holds no MOVE, it stands
  ChassisSpeed wanted_;
  ChassisSpeed now_;
  Time stepped_{};  // speed() was asked
  bool overdue_ = false;
};

}  // namespace rack::device
