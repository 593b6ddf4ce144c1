// LadarSickLms100: driver of a SICK LMS100, 111 or another LMS1xx on the network.
#include "components/devices/drivers/sick_cola_ladar.h"

namespace rack::device {
namespace {

constexpr std::int32_t kMaxRange = 20000;  // mm
constexpr std::chrono::milliseconds kPeriod(20);

constexpr auto kParameters = driver_parameters(std::array<ParameterInfo, 3>{{
    {"lmsIp", "", "address of the scanner, e.g. 192.168.0.1"},
    {"lmsPort", 2112, "TCP port of the scanner, 2111 or 2112", 1, 65535},
    {"reflectorRemission", 1000, "minimum remission of a reflector; 0: report no reflectors", 0,
     65535},
}});

constexpr ModuleInfo kInfo{
    .program = "LadarSickLms100",
    .purpose = "A SICK LMS1xx laser range finder on the network.",
    .class_id = tims::class_id::kLadar,
    .parameters = kParameters,
};

class LadarSickLms100 : public SickColaLadar {
 public:
  LadarSickLms100() : SickColaLadar(kInfo) {}

 private:
  Result<DeviceOptions> device() const override {
    std::string address = text("device");
    if (address.empty() && text("lmsIp").empty())
      return refused("lmsIp is missing; example: --lmsIp=192.168.0.1");
    if (address.empty()) {
      const std::string host = text("lmsIp");
      const bool is_v6 = host.find(':') != std::string::npos;
      address =
          "tcp:" + (is_v6 ? "[" + host + "]" : host) + ":" + std::to_string(integer("lmsPort"));
    }
    const auto parsed = DeviceAddress::parse(address);
    if (!parsed) return parsed.error();
    return DeviceOptions{.address = *parsed, .record = text("record")};
  }

  Result<std::unique_ptr<SickCola>> make_dialogue() override {
    set_period(kPeriod);
    return make(
        {.view = {.max_range = kMaxRange, .reflector_remission = integer("reflectorRemission")},
         .only_listen = is_recording()});
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::LadarSickLms100 ladar;
  return ladar.run(argc, argv);
}
