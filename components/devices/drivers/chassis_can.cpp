// ChassisCan: driver of a vehicle with ODrive or VESC motor controllers on a CAN bus.
#include "components/devices/chassis/odrive.h"
#include "components/devices/chassis/vesc.h"
#include "components/devices/drivers/can_chassis.h"

namespace rack::device {
namespace {

constexpr auto kParameters = chassis_parameters(
    joined(can_chassis_parameters(0),
           std::array<ParameterInfo, 2>{{
               one_of("0 ODrive, 1 VESC", {"controller", 0, "controller of the motors", 0, 1}),
               {"polePairs", 7, "pole pairs of a motor (VESC only)", 1, 100},
           }}),
    ChassisDefaults{.wheelRadius = 85});

constexpr ModuleInfo kInfo{
    .program = "ChassisCan",
    .purpose =
        "A differential or steered vehicle with ODrive or VESC motor controllers on a CAN "
        "bus. A guard process stops the motors when the driver crashes. When the cable is cut, a "
        "VESC stops after 1 s, an ODrive only if its watchdog is enabled.",
    .class_id = tims::class_id::kChassis,
    .parameters = kParameters,
};

class ChassisCan : public CanChassis {
 public:
  ChassisCan() : CanChassis(kInfo) {}

 private:
  [[nodiscard]] bool is_vesc() const { return integer("controller") == 1; }
  [[nodiscard]] bool is_canopen() const override { return false; }
  [[nodiscard]] std::uint8_t last_node() const override { return is_vesc() ? 254 : 62; }
  [[nodiscard]] bool turns_on_the_spot() const override { return integer("steering") == 0; }

  Result<std::unique_ptr<Motor>> make_motor(std::uint8_t node, MotorTask task) const override {
    if (!is_vesc()) return std::unique_ptr<Motor>(std::make_unique<Odrive>(node, task));
    return std::unique_ptr<Motor>(std::make_unique<Vesc>(
        VescSettings{.node = node, .task = task, .pole_pairs = integer("polePairs")}));
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::ChassisCan chassis;
  return chassis.run(argc, argv);
}
