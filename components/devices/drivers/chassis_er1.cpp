// ChassisEr1: driver of an Evolution Robotics ER1 on a serial line.
#include "components/devices/chassis/er1.h"
#include "components/devices/drivers/chassis_driver.h"

namespace rack::device {
namespace {

constexpr auto kParameters = chassis_parameters(
    std::array<ParameterInfo, 7>{{
        host_file({"serialDev", "", "path of the serial line, e.g. /dev/ttyUSB0"}),
        {"axisWidth", 380, "distance between the wheels [mm]", 1, 1e5},
        {"omegaMin", 15, "slowest turn on the spot [deg/s]", 0, 3600},
        {"velFactor", 764, "velocity units of the motion processors per mm/s", 1, 1e6},
        {"odoFactorA", 117, "actual wheel speed relative to the commanded speed [%]", 0, 1e6},
        {"odoFactorB", 40, "offset subtracted from the wheel speed [mm/s]", 0, 1e6},
        {"ticksPerMetre", 0, "encoder ticks per metre; 0: odometry from odoFactorA and odoFactorB",
         0, 1e9},
    }},
    ChassisDefaults{.vxMax = 1000,
                    .vxMin = 80,
                    .omegaMax = 150,
                    .breakConstant = 40,
                    .front = 80,
                    .back = 350,
                    .left = 210,
                    .right = 210,
                    .wheelBase = 380,
                    .wheelRadius = 50,
                    .trackWidth = 380,
                    .pilotParameterB = 100});

constexpr ModuleInfo kInfo{
    .program = "ChassisEr1",
    .purpose =
        "An Evolution Robotics ER1 on a serial line. The robot has no watchdog: a guard "
        "process stops it when the driver crashes.",
    .class_id = tims::class_id::kChassis,
    .parameters = kParameters,
};

class ChassisEr1 : public ChassisDriver<Er1> {
 public:
  ChassisEr1() : ChassisDriver(kInfo) {}

 private:
  Result<DeviceOptions> device() const override {
    constexpr std::uint32_t kBaud = 250000;
    const std::string path = text("serialDev");
    const std::string address = !text("device").empty() ? text("device")
                                : path.empty()          ? ""
                                                        : "serial:" + path;
    if (address.empty()) return refused("device or serialDev must be set");
    const auto parsed = DeviceAddress::parse(address);
    if (!parsed) return parsed.error();
    return DeviceOptions{.address = *parsed, .baud = kBaud, .record = text("record")};
  }

  Result<std::unique_ptr<Er1>> make_dialogue() override {
    set_period(std::chrono::milliseconds(100));
    return std::make_unique<Er1>(
        Er1Settings{.axis_width = static_cast<double>(integer("axisWidth")),
                    .velocity_factor = static_cast<double>(integer("velFactor")),
                    .odometry_factor = integer("odoFactorA") / 100.0,
                    .odometry_offset = static_cast<double>(integer("odoFactorB")),
                    .ticks_per_mm = integer("ticksPerMetre") / 1000.0,
                    .omega_min = integer("omegaMin") * std::numbers::pi / 180,
                    .only_listen = is_recording()});
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::ChassisEr1 chassis;
  return chassis.run(argc, argv);
}
