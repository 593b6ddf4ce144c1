// Base of all chassis drivers: a chassis (rack/chassis_module.h) with a device and the safety rules
// of chassis_control.h. The vehicle stops when its pilot sends no commands, when another pilot is
// selected, or when the driver is turned off, loses its device or crashes.
//
//   class ChassisPioneer : public ChassisDriver<P2os> {
//     Result<DeviceOptions> device() const override;
//     Result<std::unique_ptr<P2os>> make_dialogue() override;
//   };
//
// After a short error the pilot may continue; after OFF or a longer error, the active pilot must be
// selected again.
#pragma once

#include <mutex>

#include "components/devices/chassis/chassis_control.h"
#include "rack/chassis_module.h"
#include "rack/devices/driver.h"

namespace rack::device {

// --- parameters

inline constexpr std::array<ParameterInfo, 1> kMoveDeadline = {{
    {"moveDeadline", 0, "validity of a MOVE [ms]; 0: three periods of the pilot", 0, 10000},
}};

// The parameters of a driver: its own, the limits of the vehicle and those of all drivers.
template <std::size_t N>
constexpr auto chassis_parameters(const std::array<ParameterInfo, N>& own,
                                  const ChassisDefaults& defaults) {
  return driver_parameters(joined(own, joined(chassis_limits(defaults), kMoveDeadline)));
}

// --- the driver

template <class Dialog>
class ChassisDriver : public ChassisModule<Driver<ChassisData, Dialog>, ChassisControl> {
  using Base = ChassisModule<Driver<ChassisData, Dialog>, ChassisControl>;

 public:
  // Each data set contains a movement, so subscribers must not skip any: no samples.
  explicit ChassisDriver(const ModuleInfo& info) : Base(info, {.history = 5, .samples = false}) {}

 protected:
  using Base::control_;
  using Base::control_mutex_;

  // False for steered vehicles.
  [[nodiscard]] virtual bool turns_on_the_spot() const { return true; }

  void steer(const ChassisMoveData& target) override { control_->move(target, now()); }
  void pilot_was_set() override { pilot_before_ = kNoPilot; }
  void commanded() override { this->wake(); }

  Result<void> module_on() override {
    {
      const std::lock_guard lock(control_mutex_);
      control_.emplace(
          this->limits(),
          ChassisRules{.turns_on_the_spot = turns_on_the_spot(),
                       .move_deadline = std::chrono::milliseconds(this->integer("moveDeadline"))});
      if (now() - failed_ < kGoesOn) control_->set_active_pilot(pilot_before_);
    }
    return Base::module_on();
  }

  void module_off() override {
    {
      const std::lock_guard lock(control_mutex_);
      control_.reset();
    }
    Base::module_off();  // stops the vehicle
  }

  Result<void> module_loop() override {
    auto done = Base::module_loop();
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
      this->log().warning("No MOVE from {} in time, stopped", control_->active_pilot());
    return control_->next_change();
  }

  Result<void> complete(ChassisData& data) override {
    const std::lock_guard lock(control_mutex_);
    data.activePilot = control_ ? control_->active_pilot() : kNoPilot;
    return {};
  }

 private:
  // After a break of at most this duration, the pilot need not be selected again.
  static constexpr tims::Duration kGoesOn = std::chrono::seconds(5);

  tims::Time failed_{};
  tims::Address pilot_before_ = kNoPilot;
};

}  // namespace rack::device
