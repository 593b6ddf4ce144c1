// ChassisPioneer: driver of a Pioneer, or another robot with P2OS, on a serial line.
#include "components/devices/chassis/p2os.h"
#include "components/devices/drivers/chassis_driver.h"
#include "components/devices/drivers/relay.h"

namespace rack::device {
namespace {

constexpr auto kParameters = chassis_parameters(
    std::array<ParameterInfo, 6>{{
        {"serialDev", 0, "serial device: 0-99 ttyS, 100-199 ttyUSB, 200-299 ttyACM", 0, 299},
        {"sonar", 0, "1: turn the sonars on", 0, 1},
        optional_partner("ladarSonar", "the Ladar that publishes the sonars",
                         "that component; -1: none"),
        {"ticksPerMetre", 48500, "encoder ticks per metre; Pioneer 3-DX: 128000", 1, 1e6},
        {"rotationWidth", 400, "effective distance between the wheels [mm]", 1, 1e5},
        {"sonarScale", 268, "sonar unit [1/1000 mm]; Pioneer 3: 1000", 1, 1e6},
    }},
    ChassisDefaults{});

constexpr ModuleInfo kInfo{
    .program = "ChassisPioneer",
    .purpose =
        "A Pioneer 2 or 3, or another robot with P2OS, on a serial line. The robot's watchdog "
        "stops it after 2 s without a command.",
    .class_id = tims::class_id::kChassis,
    .parameters = kParameters,
};

class ChassisPioneer : public ChassisDriver<P2os> {
 public:
  ChassisPioneer() : ChassisDriver(kInfo) {}

 private:
  Result<DeviceOptions> device() const override {
    return device_by("serialDev", serial_device, kBaud);
  }

  Result<std::unique_ptr<P2os>> make_dialogue() override {
    set_period(std::chrono::milliseconds(100));
    sonars_.disconnect();
    if (integer("sonar") != 0)
      if (auto on = sonars_.turn_on(); !on) return on.error();
    return std::make_unique<P2os>(
        P2osSettings{.sonar = integer("sonar") != 0,
                     .ticks_per_mm = integer("ticksPerMetre") / 1000.0,
                     .rotation_width = static_cast<double>(integer("rotationWidth")),
                     .sonar_scale = integer("sonarScale") / 1000.0,
                     .acceleration = integer("accMax"),
                     .deceleration = integer("decMax"),
                     .only_listen = is_recording()});
  }

  Result<void> complete(ChassisData& data) override {
    tims::Time measured{};
    if (sonars_ && dialogue().take_sonars(rays_, measured)) {
      rays_.recordingTime = time_stamp_of(measured);
      sonars_.send(rays_);
    }
    return ChassisDriver::complete(data);
  }

  static constexpr std::uint32_t kBaud = 9600;
  OwnMailbox work_{*this, 1, 128};
  Relay<LadarProxy> sonars_{*this, "ladarSonar", work_};
  LadarData rays_;
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::ChassisPioneer chassis;
  return chassis.run(argc, argv);
}
