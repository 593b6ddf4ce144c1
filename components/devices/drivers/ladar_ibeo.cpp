// LadarIbeo: driver of an Ibeo LD-A at a CAN interface with 1 Mbit/s. Each sector of a turn is
// published as one scan.
#include "components/devices/scanners/ibeo.h"
#include "rack/devices/driver.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(std::array<ParameterInfo, 2>{{
    {"canDev", 0, "number N of the CAN interface canN", 0, 99},
    {"sensorId", 1, "id of the scanner, as configured", 1, 254},
}});

constexpr ModuleInfo kInfo{
    .program = "LadarIbeo",
    .purpose = "An Ibeo LD-A laser range finder at a CAN interface.",
    .class_id = tims::class_id::kLadar,
    .parameters = kParameters,
};

class LadarIbeo final : public Driver<LadarData, Ibeo> {
 public:
  LadarIbeo() : Driver(kInfo, {.history = 10}) {}

 private:
  Result<DeviceOptions> device() const override { return device_by("canDev", can_device, 0); }

  Result<std::unique_ptr<Ibeo>> make_dialogue() override {
    set_period(std::chrono::milliseconds(100));
    return std::make_unique<Ibeo>(IbeoSettings{
        .sensor = static_cast<std::uint8_t>(integer("sensorId")), .only_listen = is_recording()});
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::LadarIbeo ladar;
  return ladar.run(argc, argv);
}
