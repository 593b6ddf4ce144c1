// What every chassis driver is: a chassis (rack/chassis_module.h) with a device, and the safety
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

#include "components/devices/chassis/chassis_control.h"
#include "components/devices/drivers/driver.h"
#include "rack/chassis_module.h"

namespace rack::device {

// --- parameters

inline constexpr std::array<ParameterInfo, 1> kMoveDeadline = {{
    {"moveDeadline", 0, "how long a MOVE holds, ms; 0: three periods of the pilot", 0, 10000},
}};

// The driver's own, its limits, and those of all drivers.
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
  // A movement that is left out is lost: no samples.
  explicit ChassisDriver(const ModuleInfo& info) : Base(info, {.history = 5, .samples = false}) {}

 protected:
  using Base::control_;
  using Base::control_mutex_;

  // Steered vehicles do not.
  [[nodiscard]] virtual bool turns_on_the_spot() const { return true; }

  void steer(const ChassisMoveData& wish) override { control_->move(wish, now()); }
  void pilot_is_said() override { pilot_before_ = kNoPilot; }
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
    Base::module_off();  // the vehicle is told to stand
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
      this->log().warning("No MOVE of %n in time, stopped", control_->active_pilot());
    return control_->next_change();
  }

  Result<void> complete(ChassisData& data) override {
    const std::lock_guard lock(control_mutex_);
    data.activePilot = control_ ? control_->active_pilot() : kNoPilot;
    return {};
  }

 private:
  // So short a break needs nobody to say again who drives.
  static constexpr tims::Duration kGoesOn = std::chrono::seconds(5);

  tims::Time failed_{};
  tims::Address pilot_before_ = kNoPilot;
};

}  // namespace rack::device
