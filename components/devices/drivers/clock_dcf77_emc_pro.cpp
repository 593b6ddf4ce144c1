// ClockDcf77EmcPro: a Gude EMC Professional, which hears DCF77.
#include "components/devices/drivers/clock_dcf77.h"

namespace rack::device {
namespace {

constexpr std::uint32_t kBaud = 9600;  // it has no other

constexpr auto kParameters = driver_parameters(kClockParameters);

constexpr ModuleInfo kInfo{
    .program = "ClockDcf77EmcPro",
    .purpose = "A radio clock Gude EMC Professional (DCF77) at a serial line.",
    .class_id = tims::class_id::kClock,
    .parameters = kParameters,
};

class ClockDcf77EmcPro : public ClockDcf77 {
 public:
  ClockDcf77EmcPro() : ClockDcf77(kInfo, Dcf77Kind::kEmcPro) {}

 private:
  Result<DeviceOptions> device() const override {
    return device_by("serialDev", serial_device, kBaud);
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::ClockDcf77EmcPro clock;
  return clock.run(argc, argv);
}
