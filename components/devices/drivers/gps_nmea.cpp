// GpsNmea: driver of a satellite receiver with NMEA 0183.
#include <numbers>

#include "components/devices/drivers/gps_driver.h"
#include "components/devices/positioning/nmea_receiver.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(joined(
    std::array<ParameterInfo, 10>{{
        {"serialDev", 0, "serial device: 0-99 ttyS, 100-199 ttyUSB, 200-299 ttyACM", 0, 299},
        {"baudrate", 4800, "baud rate of the line [bit/s]", 1200, 4000000},
        {"periodTime", 1000, "period of the receiver [ms]", 10, 60000},
        one_of("0 RMC, 1 GGA, 2 GSA, 3 VTG",
               {"trigMsgStart", 0, "first sentence of a data set", 0, 3}),
        one_of("0 RMC, 1 GGA, 2 GSA, 3 VTG",
               {"trigMsgEnd", 0, "last sentence of a data set", 0, 3}),
        {"sdXYMax", 50000, "standard deviation of the position with 4 satellites [mm]", 0},
        {"sdXYMin", 10000, "standard deviation of the position with 12 or more satellites [mm]", 0},
        {"sdZMax", 100000, "standard deviation of the height with 4 satellites [mm]", 0},
        {"sdZMin", 20000, "standard deviation of the height with 12 or more satellites [mm]", 0},
        {"sdRho", 20, "standard deviation of the heading [deg]", 0, 180},
    }},
    kGpsParameters));

constexpr ModuleInfo kInfo{
    .program = "GpsNmea",
    .purpose = "A satellite receiver with NMEA 0183, on a serial line or the network.",
    .class_id = tims::class_id::kGps,
    .parameters = kParameters,
};

class GpsNmea : public GpsDriver<NmeaReceiver> {
 public:
  GpsNmea() : GpsDriver(kInfo, {.history = 10}) {}

 private:
  Result<DeviceOptions> device() const override {
    return device_by("serialDev", serial_device, static_cast<std::uint32_t>(integer("baudrate")));
  }

  Result<std::unique_ptr<NmeaReceiver>> make_dialogue() override {
    const std::chrono::milliseconds period(integer("periodTime"));
    set_period(period);
    const double rho = integer("sdRho") * std::numbers::pi / 180;
    return std::make_unique<NmeaReceiver>(
        NmeaSettings{.start = static_cast<NmeaKind>(integer("trigMsgStart")),
                     .end = static_cast<NmeaKind>(integer("trigMsgEnd")),
                     .period = period,
                     .deviations = {.xy_max = integer("sdXYMax"),
                                    .xy_min = integer("sdXYMin"),
                                    .z_max = integer("sdZMax"),
                                    .z_min = integer("sdZMin"),
                                    .rho = static_cast<f32>(rho)},
                     .baud = static_cast<std::uint32_t>(integer("baudrate")),
                     .only_listen = is_recording()});
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::GpsNmea gps;
  return gps.run(argc, argv);
}
