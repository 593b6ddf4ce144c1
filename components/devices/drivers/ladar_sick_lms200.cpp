// LadarSickLms200: driver of a SICK LMS2xx on a serial line.
#include "components/devices/scanners/lms200.h"
#include "rack/devices/driver.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(std::array<ParameterInfo, 3>{{
    {"serialDev", 0, "serial device: 0-99 ttyS, 100-199 ttyUSB, 200-299 ttyACM", 0, 299},
    one_of("0 normal, 1 interlaced, 2 fast", {"protocol", 0, "protocol of the scanner", 0, 2}),
    one_of("9600, 19200, 38400, 500000",
           {"baudrate", 38400, "baud rate of the line [bit/s]", 9600, 500000}),
}});

constexpr ModuleInfo kInfo{
    .program = "LadarSickLms200",
    .purpose = "A SICK LMS200, 211, 221 or 291 laser range finder on a serial line.",
    .class_id = tims::class_id::kLadar,
    .parameters = kParameters,
};

class LadarSickLms200 : public Driver<LadarData, Lms200> {
 public:
  LadarSickLms200() : Driver(kInfo, {.history = 10}) {}

 private:
  Result<DeviceOptions> device() const override {
    return device_by("serialDev", serial_device, static_cast<std::uint32_t>(integer("baudrate")));
  }

  Result<std::unique_ptr<Lms200>> make_dialogue() override {
    const Lms200Settings settings{.baud = static_cast<std::uint32_t>(integer("baudrate")),
                                  .mode = static_cast<Lms200Mode>(integer("protocol")),
                                  .only_listen = is_recording()};
    constexpr std::array<std::uint32_t, 4> kRates = {9600, 19200, 38400, 500000};
    if (std::ranges::find(kRates, settings.baud) == kRates.end())
      return refused("baudrate must be 9600, 19200, 38400 or 500000");
    if (settings.mode == Lms200Mode::kInterlaced && settings.baud != 500000)
      return refused("protocol=1 (interlaced) needs baudrate=500000");
    // Duration of a whole scan at 38400 baud; at 500000 baud the turn of the mirror.
    set_period(std::chrono::milliseconds(settings.mode == Lms200Mode::kNormal ? 213 : 13));
    return std::make_unique<Lms200>(settings);
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::LadarSickLms200 ladar;
  return ladar.run(argc, argv);
}
