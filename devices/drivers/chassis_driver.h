// What every chassis driver is: the commands of the class, the limits as parameters, and the safety
// rule (chassis_control.h): the vehicle stands when its pilot is silent, is another one, or when
// the driver is turned off, loses its device, or dies.
//
//   class ChassisPioneer : public ChassisDriver<P2os> {
//     Result<DeviceOptions> device() const override;
//     Result<std::unique_ptr<P2os>> make_dialogue() override;
//   };
//
// After an error that lasted a moment only, the pilot may go on; after OFF, or a longer error,
// somebody has to say again who drives.
#pragma once

#include <mutex>
#include <numbers>
#include <optional>

#include "devices/chassis/chassis_control.h"
#include "devices/drivers/driver.h"

namespace rack::device {

// --- parameters

// Of the vehicle as it comes; a driver says what is different.
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

constexpr std::array<ParameterInfo, 21> chassis_limits(const ChassisDefaults& of) {
  constexpr double kMost = 1e6;
  return {{
      {"vxMax", of.vxMax, "largest speed, mm/s", 0, kMost},
      {"vxMin", of.vxMin, "smallest speed that is not 0, mm/s", 0, kMost},
      {"accMax", of.accMax, "acceleration, mm/s2; 0: any", 0, kMost},
      {"decMax", of.decMax, "deceleration, mm/s2; 0: any", 0, kMost},
      {"omegaMax", of.omegaMax, "largest turning speed, deg/s", 0, 3600},
      {"minTurningRadius", of.minTurningRadius, "mm", 0, kMost},
      {"breakConstant", of.breakConstant, "way for braking, mm for each 100 mm/s", 0, kMost},
      {"safetyMargin", of.safetyMargin, "around the hull, mm", 0, kMost},
      {"safetyMarginMove", of.safetyMarginMove, "more of it where it goes, mm", 0, kMost},
      {"comfortMargin", of.comfortMargin, "mm", 0, kMost},
      {"front", of.front, "hull before the reference point, mm", 0, kMost},
      {"back", of.back, "hull behind it, mm", 0, kMost},
      {"left", of.left, "hull left of it, mm", 0, kMost},
      {"right", of.right, "hull right of it, mm", 0, kMost},
      {"wheelBase", of.wheelBase, "mm", 0, kMost},
      {"wheelRadius", of.wheelRadius, "mm", 0, kMost},
      {"trackWidth", of.trackWidth, "mm", 0, kMost},
      {"pilotParameterA", of.pilotParameterA, "gain for the distance to the path, 1/10000 rad/mm",
       0, kMost},
      {"pilotParameterB", of.pilotParameterB, "gain for the heading, 1/100 1/s", 0, kMost},
      {"pilotVTransMax", of.pilotVTransMax, "mm/s", 0, kMost},
      {"moveDeadline", 0, "how long a MOVE holds, ms; 0: three periods of the pilot", 0, 10000},
  }};
}

// The driver's own, its limits, and those of all drivers.
template <std::size_t N>
constexpr auto chassis_parameters(const std::array<ParameterInfo, N>& own,
                                  const ChassisDefaults& defaults) {
  return driver_parameters(joined(own, chassis_limits(defaults)));
}

// --- the driver

template <class Dialog>
class ChassisDriver : public Driver<ChassisData, Dialog> {
 public:
  // A movement that is left out is lost: no samples.
  explicit ChassisDriver(const ModuleInfo& info)
      : Driver<ChassisData, Dialog>(info, {.history = 5, .samples = false}) {}

 protected:
  // Parameters are read at every ON.
  [[nodiscard]] virtual ChassisParamData limits() const;
  // Steered vehicles do not.
  [[nodiscard]] virtual bool turns_on_the_spot() const { return true; }

  Result<void> module_on() override {
    {
      const std::lock_guard lock(control_mutex_);
      control_.emplace(
          limits(),
          ChassisRules{.turns_on_the_spot = turns_on_the_spot(),
                       .move_deadline = std::chrono::milliseconds(this->integer("moveDeadline"))});
      if (now() - failed_ < kGoesOn) control_->set_active_pilot(pilot_before_);
    }
    return Driver<ChassisData, Dialog>::module_on();
  }

  void module_off() override {
    {
      const std::lock_guard lock(control_mutex_);
      control_.reset();
    }
    Driver<ChassisData, Dialog>::module_off();  // the vehicle is told to stand
  }

  Result<void> module_loop() override {
    auto done = Driver<ChassisData, Dialog>::module_loop();
    if (!done) {
      const std::lock_guard lock(control_mutex_);
      failed_ = now();
      pilot_before_ = control_ ? control_->active_pilot() : kNoPilot;
    }
    return done;
  }

  tims::Time prepare(tims::Time now) override {
    const std::lock_guard lock(control_mutex_);
    if (!control_) return tims::kNever;
    this->dialogue().drive(control_->speed(now), now);
    if (control_->take_overdue())
      this->log().warning("No MOVE of %n in time, stopped", control_->active_pilot());
    return control_->next_change();
  }

  Result<void> complete(ChassisData& data) override {
    const std::lock_guard lock(control_mutex_);
    data.activePilot = control_ ? control_->active_pilot() : kNoPilot;
    return {};
  }

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
        return Driver<ChassisData, Dialog>::module_command(message);
    }
  }

 private:
  // So short a break needs nobody to say again who drives.
  static constexpr tims::Duration kGoesOn = std::chrono::seconds(5);

  Result<void> move(const tims::MessageView& message);
  Result<void> set_active_pilot(const tims::MessageView& message);

  [[nodiscard]] ChassisParamData limits_in_force() {
    {
      const std::lock_guard lock(control_mutex_);
      if (control_) return control_->limits();
    }
    return limits();
  }

  PriorityMutex control_mutex_;
  std::optional<ChassisControl> control_;  // while it is on
  tims::Time failed_{};
  tims::Address pilot_before_ = kNoPilot;
};

template <class Dialog>
Result<void> ChassisDriver<Dialog>::move(const tims::MessageView& message) {
  const auto wish = decode<ChassisMoveData>(message);
  if (!wish) return wish.error();
  const tims::Address pilot = this->component_of(message.header.src);
  {
    const std::lock_guard lock(control_mutex_);
    if (!control_) return this->refused("the chassis is off");
    const tims::Address active = control_->active_pilot();
    if (pilot != active) {
      const auto widths = this->address_widths();
      return this->refused(
          pilot.to_string(widths) + " is not its active pilot, " +
          (active == kNoPilot ? "it has none" : "that is " + active.to_string(widths)));
    }
    control_->move(*wish, now());
  }
  this->wake();
  this->reply(message.header, tims::type::kOk);
  return {};
}

template <class Dialog>
Result<void> ChassisDriver<Dialog>::set_active_pilot(const tims::MessageView& message) {
  const auto wish = decode<ChassisSetActivePilotData>(message);
  if (!wish) return wish.error();
  const bool none = wish->activePilot == kNoPilot;
  const tims::Address pilot = none ? kNoPilot : this->component_of(wish->activePilot);
  bool is_new = false;
  {
    const std::lock_guard lock(control_mutex_);
    pilot_before_ = kNoPilot;
    is_new = control_ && control_->active_pilot() != pilot;
    if (control_) control_->set_active_pilot(pilot);
  }
  this->wake();
  if (is_new && none) this->log().print("No active pilot, says %n", message.header.src);
  if (is_new && !none) this->log().print("Active pilot is %n, says %n", pilot, message.header.src);
  this->reply(message.header, tims::type::kOk);
  return {};
}

template <class Dialog>
ChassisParamData ChassisDriver<Dialog>::limits() const {
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

}  // namespace rack::device
