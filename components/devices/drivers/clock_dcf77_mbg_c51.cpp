// ClockDcf77MbgC51: driver of a DCF77 radio clock Meinberg C51, or another with its telegram.
#include "components/devices/drivers/clock_dcf77.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(
    joined(kClockParameters, std::array<ParameterInfo, 1>{{
                                 {"baudrate", 9600, "baud rate of the line [bit/s]", 300, 115200},
                             }}));

constexpr ModuleInfo kInfo{
    .program = "ClockDcf77MbgC51",
    .purpose = "A DCF77 radio clock Meinberg C51, or another with its standard telegram.",
    .class_id = tims::class_id::kClock,
    .parameters = kParameters,
};

class ClockDcf77MbgC51 : public ClockDcf77 {
 public:
  ClockDcf77MbgC51() : ClockDcf77(kInfo, Dcf77Kind::kMeinberg) {}

 private:
  Result<DeviceOptions> device() const override {
    return device_by("serialDev", serial_device, static_cast<std::uint32_t>(integer("baudrate")));
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::ClockDcf77MbgC51 clock;
  return clock.run(argc, argv);
}
