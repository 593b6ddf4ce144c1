// LadarRplidar: driver of the rotating range finders of small robots, Slamtec RPLIDAR A, S, C and
// LDROBOT LD06, LD19.
#include "components/devices/scanners/ld19.h"
#include "components/devices/scanners/rplidar.h"
#include "rack/devices/driver.h"

namespace rack::device {
namespace {

constexpr std::string_view kRplidar = "rplidar";
constexpr std::uint32_t kBaudOfRplidar = 115200;
constexpr std::uint32_t kBaudOfLd19 = 230400;

constexpr auto kParameters = driver_parameters(std::array<ParameterInfo, 7>{{
    {"serialDev", 100, "serial device: 0-99 ttyS, 100-199 ttyUSB, 200-299 ttyACM", 0, 299},
    one_of("rplidar (A and C and S series), ld06, ld19 (also STL-19P)",
           {"model", kRplidar, "model of the scanner"}),
    {"baudrate", 0, "115200 A1 A2, 256000 A3 S1, 460800 C1, 1000000 S2 S3; 0: detect", 0, 2000000},
    one_of("0 best mode of the scanner, 1 single points (all scanners)",
           {"scanMode", 0, "mode of measuring", 0, 1}),
    {"turnsPerMinute", 0, "speed of C and S series [1/min]; 0: default of the scanner", 0, 1200},
    {"periodTime", 100, "period of a turn [ms]", 10, 1000},
    {"serialNumber", "", "required serial number of the scanner, 32 hex digits; empty: any"},
}});

constexpr ModuleInfo kInfo{
    .program = "LadarRplidar",
    .purpose = "A rotating laser range finder: RPLIDAR A, S, C series, LD06, LD19.",
    .class_id = tims::class_id::kLadar,
    .parameters = kParameters,
};

class LadarRplidar final : public Driver<LadarData, TurningLadar> {
 public:
  LadarRplidar() : Driver(kInfo, {.history = 10}) {}

 private:
  [[nodiscard]] std::uint32_t baud() const {
    const std::int32_t given = integer("baudrate");
    if (given > 0) return static_cast<std::uint32_t>(given);
    return text("model") == kRplidar ? kBaudOfRplidar : kBaudOfLd19;
  }

  Result<DeviceOptions> device() const override {
    return device_by("serialDev", serial_device, baud());
  }

  Result<std::unique_ptr<TurningLadar>> make_dialogue() override {
    const auto options = device();
    if (!options) return options.error();
    const TransportKind kind = options->address.kind;
    const std::uint32_t rate = options->address.baud(baud());
    const std::string model = text("model");
    set_period(std::chrono::milliseconds(integer("periodTime")));
    using Made = std::unique_ptr<TurningLadar>;
    if (model == kRplidar) {
      const bool is_line = kind == TransportKind::kSerial || kind == TransportKind::kPty;
      const RplidarSettings settings{.baud = rate,
                                     .has_rate = is_line,
                                     .only_points = integer("scanMode") != 0,
                                     .turns_a_minute = integer("turnsPerMinute"),
                                     .serial_number = text("serialNumber"),
                                     .only_listen = is_recording()};
      return Made(std::make_unique<Rplidar>(settings));
    }
    if (model == "ld06" || model == "ld19") {
      if (!text("serialNumber").empty())
        return refused("an " + model + " reports no serial number: serialNumber must be empty");
      const Ld19Settings settings{.baud = rate, .only_listen = is_recording()};
      return Made(std::make_unique<Ld19>(settings));
    }
    return refused("model must be rplidar, ld06 or ld19, not " + model);
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::LadarRplidar ladar;
  return ladar.run(argc, argv);
}
