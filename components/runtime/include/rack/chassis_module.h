// The base of all components of class CHASSIS: the commands of the class, the active pilot, whose
// commands are accepted, and the limits of the vehicle as parameters.
//
//   class ChassisSim : public ChassisModule<DataModule<ChassisData>, ChassisModel> {
//     void steer(const ChassisMoveData& command) override { control_->move(command); }
//   };
//
// `Control` holds the limits, the active pilot and its command; it exists while the module is on.
#pragma once

#include <array>
#include <mutex>
#include <numbers>
#include <optional>

#include "rack/data_module.h"
#include "rack/proxies/chassis.h"

namespace rack {

// --- parameters

// Default limits of a vehicle; a program overrides those that differ.
struct ChassisDefaults {
  i32 vxMax = 700;
  i32 vxMin = 50;
  i32 accMax = 500;
  i32 decMax = 500;
  i32 omegaMax = 30;
  i32 minTurningRadius = 200;
  i32 breakConstant = 100;
  i32 safetyMargin = 50;
  i32 safetyMarginMove = 200;
  i32 comfortMargin = 300;
  i32 front = 250;
  i32 back = 250;
  i32 left = 250;
  i32 right = 250;
  i32 wheelBase = 280;
  i32 wheelRadius = 110;
  i32 trackWidth = 280;
  i32 pilotParameterA = 10;
  i32 pilotParameterB = 200;
  i32 pilotVTransMax = 200;
};

constexpr std::array<ParameterInfo, 20> chassis_limits(const ChassisDefaults& of) {
  constexpr double kMost = 1e6;
  return {{
      {"vxMax", of.vxMax, "maximum speed [mm/s]", 0, kMost},
      {"vxMin", of.vxMin, "minimum speed other than 0 [mm/s]", 0, kMost},
      {"accMax", of.accMax, "acceleration [mm/s2]; 0: no limit", 0, kMost},
      {"decMax", of.decMax, "deceleration [mm/s2]; 0: no limit", 0, kMost},
      {"omegaMax", of.omegaMax, "maximum angular speed [deg/s]", 0, 3600},
      {"minTurningRadius", of.minTurningRadius, "minimum turning radius [mm]", 0, kMost},
      {"breakConstant", of.breakConstant, "braking distance [mm per 100 mm/s]", 0, kMost},
      {"safetyMargin", of.safetyMargin, "safety margin around the hull [mm]", 0, kMost},
      {"safetyMarginMove", of.safetyMarginMove, "additional margin in the direction of travel [mm]",
       0, kMost},
      {"comfortMargin", of.comfortMargin, "preferred margin [mm]", 0, kMost},
      {"front", of.front, "hull in front of the reference point [mm]", 0, kMost},
      {"back", of.back, "hull behind the reference point [mm]", 0, kMost},
      {"left", of.left, "hull left of the reference point [mm]", 0, kMost},
      {"right", of.right, "hull right of the reference point [mm]", 0, kMost},
      {"wheelBase", of.wheelBase, "distance between the axles [mm]", 0, kMost},
      {"wheelRadius", of.wheelRadius, "radius of the wheels [mm]", 0, kMost},
      {"trackWidth", of.trackWidth, "distance between left and right wheels [mm]", 0, kMost},
      {"pilotParameterA", of.pilotParameterA, "gain for the distance to the path [1/10000 rad/mm]",
       0, kMost},
      {"pilotParameterB", of.pilotParameterB, "gain for the heading [1/100 1/s]", 0, kMost},
      {"pilotVTransMax", of.pilotVTransMax, "maximum lateral speed of pilots [mm/s]", 0, kMost},
  }};
}

// --- the module

template <class Base, class Control>
class ChassisModule : public Base {
 protected:
  using Base::Base;

  // Executes a command of the active pilot. Called with the lock held, while the module is on.
  virtual void steer(const ChassisMoveData& target) = 0;
  // The active pilot was set. Called with the lock held, also while the module is off.
  virtual void pilot_was_set() {}
  // One of the two commands was executed.
  virtual void commanded() {}

  // The limits from the parameters, which are read at every ON; while off, those of the next ON.
  [[nodiscard]] virtual ChassisParamData limits() const;

  Result<void> module_command(const tims::MessageView& message) override {
    switch (message.header.type) {
      case ChassisType::kMove:
        return move(message);
      case ChassisType::kGetParameter:
        this->reply(message.header, ChassisType::kParameter, limits_in_force());
        return {};
      case ChassisType::kSetActivePilot:
        return set_active_pilot(message);
      default:
        return Base::module_command(message);
    }
  }

  PriorityMutex control_mutex_;     // "the lock"
  std::optional<Control> control_;  // while it is on

 private:
  Result<void> move(const tims::MessageView& message);
  Result<void> set_active_pilot(const tims::MessageView& message);

  [[nodiscard]] ChassisParamData limits_in_force() {
    {
      const std::lock_guard lock(control_mutex_);
      if (control_) return control_->limits();
    }
    return limits();
  }
};

template <class Base, class Control>
Result<void> ChassisModule<Base, Control>::move(const tims::MessageView& message) {
  const auto command = decode<ChassisMoveData>(message);
  if (!command) return command.error();
  const tims::Address pilot = this->component_of(message.header.src);
  {
    const std::lock_guard lock(control_mutex_);
    if (!control_) return this->refused("the chassis is off");
    const tims::Address active = control_->active_pilot();
    if (pilot != active) {
      const auto widths = this->address_widths();
      return this->refused(
          pilot.to_string(widths) + " is not the active pilot of this chassis, " +
          (active == kNoPilot ? "which has none" : "which is " + active.to_string(widths)));
    }
    steer(*command);
  }
  commanded();
  this->reply(message.header, tims::type::kOk);
  return {};
}

template <class Base, class Control>
Result<void> ChassisModule<Base, Control>::set_active_pilot(const tims::MessageView& message) {
  const auto command = decode<ChassisSetActivePilotData>(message);
  if (!command) return command.error();
  const bool none = command->activePilot == kNoPilot;
  const tims::Address pilot = none ? kNoPilot : this->component_of(command->activePilot);
  bool is_new = false;
  {
    const std::lock_guard lock(control_mutex_);
    pilot_was_set();
    is_new = control_ && control_->active_pilot() != pilot;
    if (control_) control_->set_active_pilot(pilot);
  }
  commanded();
  if (is_new && none) this->log().print("No active pilot, set by {}", message.header.src);
  if (is_new && !none)
    this->log().print("Active pilot is {}, set by {}", pilot, message.header.src);
  this->reply(message.header, tims::type::kOk);
  return {};
}

template <class Base, class Control>
ChassisParamData ChassisModule<Base, Control>::limits() const {
  const auto number = [&](std::string_view name) { return this->integer(name); };
  ChassisParamData limits;
  limits.vxMax = number("vxMax");
  limits.vxMin = number("vxMin");
  limits.accMax = number("accMax");
  limits.decMax = number("decMax");
  limits.omegaMax = static_cast<float>(number("omegaMax") * std::numbers::pi / 180);
  limits.minTurningRadius = number("minTurningRadius");
  limits.breakConstant = static_cast<float>(number("breakConstant")) / 100;
  limits.safetyMargin = number("safetyMargin");
  limits.safetyMarginMove = number("safetyMarginMove");
  limits.comfortMargin = number("comfortMargin");
  limits.boundaryFront = number("front");
  limits.boundaryBack = number("back");
  limits.boundaryLeft = number("left");
  limits.boundaryRight = number("right");
  limits.wheelBase = number("wheelBase");
  limits.wheelRadius = number("wheelRadius");
  limits.trackWidth = number("trackWidth");
  limits.pilotParameterA = static_cast<float>(number("pilotParameterA")) / 10000;
  limits.pilotParameterB = static_cast<float>(number("pilotParameterB")) / 100;
  limits.pilotVTransMax = number("pilotVTransMax");
  return limits;
}

}  // namespace rack
