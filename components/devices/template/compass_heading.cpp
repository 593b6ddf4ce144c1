// CompassHeading: a compass at a serial line that answers "?" with degrees.
#include <array>
#include <chrono>
#include <memory>

#include <rack/devices/driver.h>

#include "heading.h"

namespace heading {
namespace {

constexpr auto kParameters = rack::device::driver_parameters(std::array<rack::ParameterInfo, 2>{{
    {"serialDev", 100, "0 to 99 ttyS, 100 to 199 ttyUSB, 200 to 299 ttyACM", 0, 299},
    {"periodTime", 100, "period of the data [ms]", 20, 10000},
}});

constexpr rack::ModuleInfo kInfo{
    .program = "CompassHeading",
    .purpose = "A compass at a serial line that answers ? with degrees.",
    .class_id = tims::class_id::kCompass,
    .parameters = kParameters,
};

class CompassHeading : public rack::device::Driver<rack::CompassData, Heading> {
 public:
  CompassHeading() : Driver(kInfo, {.history = 10}) {}

 private:
  rack::Result<rack::device::DeviceOptions> device() const override {
    return device_by("serialDev", rack::device::serial_device, 9600);
  }
  rack::Result<std::unique_ptr<Heading>> make_dialogue() override {
    const std::chrono::milliseconds period(integer("periodTime"));
    set_period(period);
    return std::make_unique<Heading>(period);
  }
};

}  // namespace
}  // namespace heading

int main(int argc, char** argv) {
  heading::CompassHeading compass;
  return compass.run(argc, argv);
}
