// LadarSickS: driver of a SICK S300 or S3000 on a serial line.
#include "components/devices/scanners/sick_s.h"
#include "rack/devices/driver.h"

namespace rack::device {
namespace {

constexpr std::int32_t kRate = 500000;

constexpr auto kParameters = driver_parameters(std::array<ParameterInfo, 4>{{
    one_of("300, 3000", {"devNumber", 300, "model of the scanner", 300, 3000, true}),
    {"serialDev", 0, "serial device: 0-99 ttyS, 100-199 ttyUSB, 200-299 ttyACM", 0, 299},
    one_of("0 master, 1 slave", {"EFIdev", 0, "place at the EFI bus", 0, 1}),
    {"baudrate", kRate, "baud rate configured in the scanner [bit/s], at most 500000", 9600, kRate},
}});

constexpr ModuleInfo kInfo{
    .program = "LadarSickS",
    .purpose = "A SICK S300 or S3000 safety laser range finder on a serial line.",
    .class_id = tims::class_id::kLadar,
    .parameters = kParameters,
};

class LadarSickS : public Driver<LadarData, SickS> {
 public:
  LadarSickS() : Driver(kInfo, {.history = 5}) {}

 private:
  Result<DeviceOptions> device() const override {
    return device_by("serialDev", serial_device, static_cast<std::uint32_t>(integer("baudrate")));
  }

  Result<std::unique_ptr<SickS>> make_dialogue() override {
    const std::int32_t number = integer("devNumber");
    if (number != 300 && number != 3000) return refused("devNumber must be 300 or 3000");
    const bool is_small = number == 300;
    const std::int32_t baud = integer("baudrate");
    // As in the original: the period is inversely proportional to the baud rate.
    set_period(std::chrono::milliseconds(kRate / baud * (is_small ? 40 : 30)));
    return std::make_unique<SickS>(
        SickSSettings{.device = is_small ? SickSDevice::kS300 : SickSDevice::kS3000,
                      .is_slave = integer("EFIdev") == 1,
                      .baud = static_cast<std::uint32_t>(baud)});
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::LadarSickS ladar;
  return ladar.run(argc, argv);
}
