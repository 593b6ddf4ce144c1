// GpsUblox: driver of a u-blox receiver with UBX in addition to NMEA.
#include "components/devices/drivers/gps_driver.h"
#include "components/devices/positioning/ublox.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(joined(
    std::array<ParameterInfo, 3>{{
        {"serialDev", 0, "serial device: 0-99 ttyS, 100-199 ttyUSB, 200-299 ttyACM", 0, 299},
        {"baudrate", 0, "baud rate to set in the receiver [bit/s]; 0: keep the current one", 0,
         921600},
        {"periodTime", 1000,
         "period of fixes [ms]; a fix with NMEA is 600 bytes: 200 needs 57600 baud", 25, 60000},
    }},
    kGpsParameters));

constexpr ModuleInfo kInfo{
    .program = "GpsUblox",
    .purpose = "A u-blox satellite receiver (generations 7 to 10) with UBX in addition to NMEA.",
    .class_id = tims::class_id::kGps,
    .parameters = kParameters,
};

class GpsUblox : public GpsDriver<Ublox> {
 public:
  GpsUblox() : GpsDriver(kInfo, {.history = 10}) {}

 private:
  Result<DeviceOptions> device() const override {
    constexpr std::uint32_t kFirst = 38400;  // first rate tried by the search
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
