// LadarSickPicoScan: driver of a SICK picoScan100 or multiScan100, which send segments by UDP.
#include "components/devices/scanners/sick_compact.h"
#include "rack/devices/driver.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(std::array<ParameterInfo, 3>{{
    {"periodTime", 50, "period of a turn [ms]: 20 to 67", 1, 1000},
    {"maxRange", 75000, "range of the scanner [mm]", 1, 1000000},
    {"serialNumber", 0, "required serial number of the scanner; 0: any", 0},
}});

constexpr ModuleInfo kInfo{
    .program = "LadarSickPicoScan",
    .purpose = "A SICK picoScan100 laser range finder, or the level layer of a multiScan100.",
    .class_id = tims::class_id::kLadar,
    .parameters = kParameters,
};

class LadarSickPicoScan : public Driver<LadarData, SickCompact> {
 public:
  LadarSickPicoScan() : Driver(kInfo, {.history = 10}) {}

 private:
  Result<DeviceOptions> device() const override {
    const std::string given = text("device");
    const auto address = DeviceAddress::parse(given.empty() ? "udp::2115" : given);
    if (!address) return address.error();
    return DeviceOptions{.address = *address, .record = text("record")};
  }

  Result<std::unique_ptr<SickCompact>> make_dialogue() override {
    set_period(std::chrono::milliseconds(integer("periodTime")));
    return std::make_unique<SickCompact>(
        SickCompactSettings{.serial_number = static_cast<std::uint32_t>(integer("serialNumber")),
                            .max_range = integer("maxRange")});
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::LadarSickPicoScan ladar;
  return ladar.run(argc, argv);
}
