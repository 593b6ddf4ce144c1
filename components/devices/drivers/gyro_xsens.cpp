// GyroXsens: an inertial measurement unit Xsens MTi or MTx.
#include "components/devices/drivers/driver.h"
#include "components/devices/positioning/xsens.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(std::array<ParameterInfo, 5>{{
    {"serialDev", 0, "0 to 99 ttyS, 100 to 199 ttyUSB, 200 to 299 ttyACM", 0, 299},
    {"baudrate", 115200, "of the line", 9600, 4000000},
    {"periodTime", 10, "of the data, ms", 5, 1000},
    {"mounting", 0,
     "0 as the original: what the device says; 1 label up, 2 label down: angles of the robot", 0,
     2},
    {"serialNumber", "", "of the only device that will do, its id in hex; empty: any"},
}});

constexpr ModuleInfo kInfo{
    .program = "GyroXsens",
    .purpose = "An inertial measurement unit Xsens MTi or MTx: MTData and MTData2.",
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
