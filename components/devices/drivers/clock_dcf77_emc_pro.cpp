// ClockDcf77EmcPro: driver of a DCF77 radio clock Gude EMC Professional.
#include "components/devices/drivers/clock_dcf77.h"

namespace rack::device {
namespace {

constexpr std::uint32_t kBaud = 9600;  // fixed in the device

constexpr auto kParameters = driver_parameters(kClockParameters);

constexpr ModuleInfo kInfo{
    .program = "ClockDcf77EmcPro",
    .purpose = "A DCF77 radio clock Gude EMC Professional on a serial line.",
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
