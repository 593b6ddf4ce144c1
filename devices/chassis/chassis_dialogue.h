// How a chassis driver talks with its vehicle, whichever it is.
#pragma once

#include "devices/chassis/chassis_control.h"
#include "devices/core/dialogue.h"

namespace rack::device {

class ChassisDialogue : public Dialogue {
 public:
  // From now on; sent as soon as the device may be told. What was wanted before is forgotten.
  virtual void drive(const ChassisSpeed& speed, Time now) = 0;

  [[nodiscard]] virtual bool is_ready() const = 0;
  // All but the active pilot.
  virtual bool take(ChassisData& data, Time& recorded) = 0;
};

}  // namespace rack::device
