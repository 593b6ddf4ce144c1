// Base of the drivers of vehicles with CiA 402 drives: Chassis402 and ChassisRobucar.
#pragma once

#include "components/devices/drivers/can_chassis.h"

namespace rack::device {

constexpr auto cia402_parameters(i32 steering) {
  return joined(can_chassis_parameters(steering),
                std::array<ParameterInfo, 3>{{
                    {"increments", 4096, "encoder increments per turn of the motor", 1, 1e9},
                    {"velocityUnits", 0,
                     "velocity units of the drive per turn/s; 60: rpm; 0: increments/s", 0, 1e9},
                    {"quickStop", 2000, "deceleration of a quick stop [mm/s2]", 1, 1e6},
                }});
}

class Cia402Chassis : public CanChassis {
 public:
  using CanChassis::CanChassis;

 private:
  [[nodiscard]] bool is_canopen() const override { return true; }
  [[nodiscard]] std::uint8_t last_node() const override { return canopen::kHost - 1; }
  [[nodiscard]] bool turns_on_the_spot() const override { return integer("steering") == 0; }

  Result<std::unique_ptr<Motor>> make_motor(std::uint8_t node, MotorTask task) const override {
    if (node == 0) return refused("nodes=" + text("nodes") + ": 0 is not a CANopen node");
    const auto increments = static_cast<double>(integer("increments"));
    const auto units = static_cast<double>(integer("velocityUnits"));
    // Converts mm/s2 at the rim to rad/s2 at the shaft.
    const double gear = static_cast<double>(real("gearRatio")) /
                        static_cast<double>(std::max(integer("wheelRadius"), i32{1}));
    const auto ramp = [&](std::string_view name) {
      constexpr double kAny = 1e5;  // mm/s2
      const i32 value = integer(name);
      return (value > 0 ? static_cast<double>(value) : kAny) * gear;
    };
    return std::unique_ptr<Motor>(
        std::make_unique<Cia402>(Cia402Settings{.node = node,
                                                .task = task,
                                                .increments_of_turn = increments,
                                                .velocity_of_turn = units > 0 ? units : increments,
                                                .acceleration = ramp("accMax"),
                                                .deceleration = ramp("decMax"),
                                                .quick_stop = ramp("quickStop"),
                                                .only_listen = is_recording()}));
  }
};

}  // namespace rack::device
