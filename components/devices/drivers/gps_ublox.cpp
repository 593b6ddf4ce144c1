// GpsUblox: a u-blox receiver, by UBX beside NMEA.
#include "components/devices/drivers/gps_driver.h"
#include "components/devices/positioning/ublox.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(
    joined(std::array<ParameterInfo, 3>{{
               {"serialDev", 0, "0 to 99 ttyS, 100 to 199 ttyUSB, 200 to 299 ttyACM", 0, 299},
               {"baudrate", 0, "that the receiver is brought to; 0: as it is found", 0, 921600},
               {"periodTime", 1000,
                "of fixes, ms; beside NMEA each takes 600 bytes: 200 needs 57600 baud", 25, 60000},
           }},
           kGpsParameters));

constexpr ModuleInfo kInfo{
    .program = "GpsUblox",
    .purpose = "A satellite receiver of u-blox (generations 7 to 10), by UBX beside NMEA.",
    .class_id = tims::class_id::kGps,
    .parameters = kParameters,
};

class GpsUblox : public GpsDriver<Ublox> {
 public:
  GpsUblox() : GpsDriver(kInfo, {.history = 10}) {}

 private:
  Result<DeviceOptions> device() const override {
    constexpr std::uint32_t kFirst = 38400;  // it is looked for
    return device_by("serialDev", serial_device, kFirst);
  }

  Result<std::unique_ptr<Ublox>> make_dialogue() override {
    const std::chrono::milliseconds period(integer("periodTime"));
    set_period(period);
    return std::make_unique<Ublox>(
        UbloxSettings{.baud = static_cast<std::uint32_t>(integer("baudrate")),
                      .period = period,
                      .only_listen = is_recording()});
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::GpsUblox gps;
  return gps.run(argc, argv);
}
