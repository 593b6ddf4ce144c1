// LadarHokuyoUrg: driver of a Hokuyo URG, UBG, UTM or UST on a serial line, USB
// (device=serial:/dev/ttyACM0) or the network (device=tcp:192.168.0.10:10940).
#include "components/devices/drivers/ladar_hokuyo.h"

namespace rack::device {
namespace {

constexpr auto kParameters = hokuyo_parameters(std::array<ParameterInfo, 1>{{
    {"serialDev", 0, "serial device: 0-99 ttyS, 100-199 ttyUSB, 200-299 ttyACM", 0, 299},
}});

constexpr ModuleInfo kInfo{
    .program = "LadarHokuyoUrg",
    .purpose = "A Hokuyo laser range finder on a serial line, USB or the network.",
    .class_id = tims::class_id::kLadar,
    .parameters = kParameters,
};

class LadarHokuyoUrg final : public LadarHokuyo {
 public:
  LadarHokuyoUrg() : LadarHokuyo(kInfo) {}

 private:
  [[nodiscard]] Result<DeviceAddress> numbered(std::int32_t number) const override {
    return serial_device(number);
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::LadarHokuyoUrg ladar;
  return ladar.run(argc, argv);
}
