// ChassisRobucar: driver of an outdoor vehicle with four driven wheels and two steered axles, as
// the Robucar, with CANopen drives. The protocol of the original drives has never been published;
// this driver uses CiA 402.
#include "components/devices/drivers/cia402_chassis.h"

namespace rack::device {
namespace {

constexpr auto kParameters =
    chassis_parameters(cia402_parameters(2), ChassisDefaults{.vxMax = 4000,
                                                             .vxMin = 50,
                                                             .accMax = 1000,
                                                             .decMax = 2000,
                                                             .omegaMax = 60,
                                                             .minTurningRadius = 2000,
                                                             .breakConstant = 100,
                                                             .safetyMargin = 200,
                                                             .safetyMarginMove = 500,
                                                             .comfortMargin = 1000,
                                                             .front = 1150,
                                                             .back = 1150,
                                                             .left = 650,
                                                             .right = 650,
                                                             .wheelBase = 1200,
                                                             .wheelRadius = 200,
                                                             .trackWidth = 1000,
                                                             .pilotParameterA = 5,
                                                             .pilotParameterB = 100,
                                                             .pilotVTransMax = 1000});

constexpr ModuleInfo kInfo{
    .program = "ChassisRobucar",
    .purpose =
        "An outdoor vehicle with four driven wheels and two steered axles, with CANopen "
        "drives (CiA 402). The drives monitor the driver's heartbeat: after 0.2 s without it "
        "they make a quick stop.",
    .class_id = tims::class_id::kChassis,
    .parameters = kParameters,
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::Cia402Chassis chassis(rack::device::kInfo);
  return chassis.run(argc, argv);
}
