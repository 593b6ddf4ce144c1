// Chassis402: driver of a vehicle with CiA 402 drives (CANopen).
#include "components/devices/drivers/cia402_chassis.h"

namespace rack::device {
namespace {

constexpr auto kParameters = chassis_parameters(cia402_parameters(0), ChassisDefaults{});

constexpr ModuleInfo kInfo{
    .program = "Chassis402",
    .purpose =
        "A differential or steered vehicle with CANopen drives (CiA 402). The drives "
        "monitor the driver's heartbeat: after 0.2 s without it they make a quick stop.",
    .class_id = tims::class_id::kChassis,
    .parameters = kParameters,
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::Cia402Chassis chassis(rack::device::kInfo);
  return chassis.run(argc, argv);
}
