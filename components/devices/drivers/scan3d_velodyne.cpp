// Scan3dVelodyne: driver of a Velodyne scanner on the network.
#include "components/devices/drivers/scan3d_driver.h"
#include "components/devices/scan3d/velodyne.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(spin_parameters(std::array<ParameterInfo, 2>{{
    {"udpPort", 2368, "UDP port to which the scanner sends", 1, 65535},
    {"turnsPerMinute", 600, "speed configured in the scanner [1/min]", 60, 1200},
}}));

constexpr ModuleInfo kInfo{
    .program = "Scan3dVelodyne",
    .purpose = "3D scans of a Velodyne (VLP-16, Puck LITE, Hi-Res, HDL-32E, VLP-32C).",
    .class_id = tims::class_id::kScan3d,
    .parameters = kParameters,
};

Result<DeviceAddress> port(std::int32_t number) {
  return DeviceAddress{.kind = TransportKind::kUdp, .port = static_cast<std::uint16_t>(number)};
}

class Scan3dVelodyne : public Scan3dDriver<Velodyne> {
 public:
  Scan3dVelodyne() : Scan3dDriver(kInfo) {}

 private:
  Result<DeviceOptions> device() const override { return device_by("udpPort", port, 0); }

  Result<std::unique_ptr<Velodyne>> make_dialogue() override {
    set_period(std::chrono::milliseconds(60'000 / integer("turnsPerMinute") / integer("sectors")));
    return std::make_unique<Velodyne>(spin_settings());
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::Scan3dVelodyne scanner;
  return scanner.run(argc, argv);
}
