// LadarHokuyoUrgUsb: driver of a Hokuyo URG on USB; serialDev numbers /dev/ttyACM devices.
#include "components/devices/drivers/ladar_hokuyo.h"

namespace rack::device {
namespace {

constexpr std::int32_t kFirstUsb = 200;  // number of ttyACM0 for serial_device()

constexpr auto kParameters = hokuyo_parameters(std::array<ParameterInfo, 1>{{
    {"serialDev", 0, "number N of /dev/ttyACMN", 0, 99},
}});

constexpr ModuleInfo kInfo{
    .program = "LadarHokuyoUrgUsb",
    .purpose = "A Hokuyo laser range finder on USB.",
    .class_id = tims::class_id::kLadar,
    .parameters = kParameters,
};

class LadarHokuyoUrgUsb final : public LadarHokuyo {
 public:
  LadarHokuyoUrgUsb() : LadarHokuyo(kInfo) {}

 private:
  [[nodiscard]] Result<DeviceAddress> numbered(std::int32_t number) const override {
    return serial_device(kFirstUsb + number);
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::LadarHokuyoUrgUsb ladar;
  return ladar.run(argc, argv);
}
