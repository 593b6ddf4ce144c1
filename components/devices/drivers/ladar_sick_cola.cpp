// LadarSickCola: driver of a SICK LMS1xx, LMS5xx, TiM or MRS1000 with CoLa over TCP.
#include "components/devices/drivers/sick_cola_ladar.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(std::array<ParameterInfo, 6>{{
    one_of("0 detect, 1 CoLa A (ASCII), 2 CoLa B (binary)",
           {"protocol", 0, "protocol of the scanner", 0, 2}),
    {"periodTime", 20, "period of scans [ms]: LMS1xx 20 or 40, LMS5xx 10 to 40, TiM 67", 1, 1000},
    {"maxRange", 20000, "range of the scanner [mm]: LMS1xx 20000, LMS5xx 80000, TiM 25000", 1,
     1000000},
    {"reflectorRemission", 0, "minimum remission of a reflector; 0: report no reflectors", 0,
     65535},
    {"front", -1, "angle of the front on the scale of the scanner [deg]; -1: by its name", -1, 359},
    {"serialNumber", 0, "required serial number of the scanner; 0: any", 0},
}});

constexpr ModuleInfo kInfo{
    .program = "LadarSickCola",
    .purpose = "A SICK LMS1xx, LMS5xx, TiM or MRS1000 laser range finder on the network.",
    .class_id = tims::class_id::kLadar,
    .parameters = kParameters,
};

class LadarSickCola : public SickColaLadar {
 public:
  LadarSickCola() : SickColaLadar(kInfo) {}

 private:
  Result<DeviceOptions> device() const override {
    if (text("device").empty())
      return refused("device is missing; example: --device=tcp:192.168.0.1:2112");
    const auto address = DeviceAddress::parse(text("device"));
    if (!address) return address.error();
    return DeviceOptions{.address = *address, .baud = 115200, .record = text("record")};
  }

  Result<std::unique_ptr<SickCola>> make_dialogue() override {
    SickColaSettings settings{.serial_number = static_cast<std::uint32_t>(integer("serialNumber")),
                              .view = {.max_range = integer("maxRange"),
                                       .reflector_remission = integer("reflectorRemission")},
                              .only_listen = is_recording()};
    if (const std::int32_t front = integer("front"); front >= 0) settings.front = front;
    constexpr std::int32_t kAscii = 1;
    if (const std::int32_t protocol = integer("protocol"); protocol != 0)
      settings.dialect = protocol == kAscii ? ColaDialect::kAscii : ColaDialect::kBinary;
    set_period(std::chrono::milliseconds(integer("periodTime")));
    return make(settings);
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::LadarSickCola ladar;
  return ladar.run(argc, argv);
}
