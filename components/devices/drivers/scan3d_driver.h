// Base of the drivers of rotating 3D scanners: their parameters, the robot's position and the
// commands of the class.
#pragma once

#include <numbers>

#include "components/devices/scan3d/spinning_scan.h"
#include "components/scan3d/scan3d_commands.h"
#include "rack/devices/driver.h"
#include "rack/partner.h"
#include "rack/proxies/position.h"

namespace rack::device {

inline constexpr std::array<ParameterInfo, 6> kSpinParameters = {{
    {"sectors", 1, "messages per turn", 1, 64},
    {"minRange", 0, "discard points nearer than this (the robot itself) [mm]", 0, 1e6},
    {"maxRange", 0, "discard points farther than this [mm]; 0: range of the scanner", 0, 1e6},
    {"direction", 0, "direction of the scanner's front on the robot, clockwise [deg]", -360, 360},
    optional_partner("position", "the position", "the position, for refPos; -1: none"),
    kStorePath,
}};

template <std::size_t N>
constexpr auto spin_parameters(const std::array<ParameterInfo, N>& own) {
  return joined(own, kSpinParameters);
}

template <class Dialog>
class Scan3dDriver : public Scan3dCommands<Driver<Scan3dData, Dialog>> {
 public:
  explicit Scan3dDriver(const ModuleInfo& info)
      : Scan3dCommands<Driver<Scan3dData, Dialog>>(info, {.history = 4}) {}

 protected:
  using Base = Scan3dCommands<Driver<Scan3dData, Dialog>>;

  SpinSettings spin_settings() const {
    return {.sectors = this->integer("sectors"),
            .range_min = this->integer("minRange"),
            .range_max = this->integer("maxRange"),
            .direction = this->integer("direction") * std::numbers::pi / 180};
  }

  Result<void> module_on() override {
    if (auto on = position_.turn_on(); !on) return on;
    return Base::module_on();
  }

  Result<void> complete(Scan3dData& scan) override {
    if (!position_) return {};
    const auto position = position_->get_data(scan.recordingTime);
    if (!position) return position.error();
    scan.refPos = position->pos;
    return {};
  }

 private:
  OwnMailbox work_{*this, 1, 256};
  Partner<PositionProxy> position_{*this, "position", work_};
};

}  // namespace rack::device
