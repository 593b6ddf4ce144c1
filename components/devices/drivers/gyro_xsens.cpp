// GyroXsens: driver of an Xsens MTi or MTx inertial measurement unit.
#include "components/devices/positioning/xsens.h"
#include "rack/devices/driver.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(std::array<ParameterInfo, 5>{{
    {"serialDev", 0, "serial device: 0-99 ttyS, 100-199 ttyUSB, 200-299 ttyACM", 0, 299},
    {"baudrate", 115200, "baud rate of the line [bit/s]", 9600, 4000000},
    {"periodTime", 10, "period of the data [ms]", 5, 1000},
    one_of("0 of the device as the original, 1 of the robot with the label up, 2 of the robot with "
           "the label down",
           {"mounting", 0, "angles in the data", 0, 2}),
    {"serialNumber", "", "required device id, hexadecimal; empty: any"},
}});

constexpr ModuleInfo kInfo{
    .program = "GyroXsens",
    .purpose = "An Xsens MTi or MTx inertial measurement unit: MTData and MTData2.",
    .class_id = tims::class_id::kGyro,
    .parameters = kParameters,
};

class GyroXsens : public Driver<GyroData, Xsens> {
 public:
  GyroXsens() : Driver(kInfo, {.history = 100}) {}

 private:
  Result<DeviceOptions> device() const override {
    return device_by("serialDev", serial_device, static_cast<std::uint32_t>(integer("baudrate")));
  }

  Result<std::unique_ptr<Xsens>> make_dialogue() override {
    const std::chrono::milliseconds period(integer("periodTime"));
    set_period(period);
    return std::make_unique<Xsens>(
        XsensSettings{.period = period,
                      .mounting = static_cast<XsensMounting>(integer("mounting")),
                      .baud = static_cast<std::uint32_t>(integer("baudrate")),
                      .serial_number = text("serialNumber"),
                      .only_listen = is_recording()});
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::GyroXsens gyro;
  return gyro.run(argc, argv);
}
