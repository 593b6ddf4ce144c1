// What the programs for Hokuyo's range finders have in common: all but where the scanner is.
#pragma once

#include <numbers>

#include "components/devices/drivers/driver.h"
#include "components/devices/scanners/hokuyo.h"

namespace rack::device {

inline constexpr std::int32_t kHokuyoStartAngle = 120;  // what the original assumes, deg

inline constexpr std::array<ParameterInfo, 6> kHokuyoParameters = {{
    {"start", 44, "first step that is measured", 0, 9999},
    {"end", 725, "last step that is measured", 0, 9999},
    {"cluster", 3, "steps that become one point", 1, 99},
    {"startAngle", kHokuyoStartAngle,
     "where the first step looks, deg to the right; 120: as a scanner of SCIP 2 says itself", -360,
     360},
    {"intensity", 0, "1: also how much light came back (not all scanners know)", 0, 1},
    {"serialNumber", "", "of the only scanner that will do; empty: any"},
}};

template <std::size_t N>
constexpr auto hokuyo_parameters(const std::array<ParameterInfo, N>& own) {
  return driver_parameters(joined(own, kHokuyoParameters));
}

class LadarHokuyo : public Driver<LadarData, Hokuyo> {
 public:
  explicit LadarHokuyo(const ModuleInfo& info) : Driver(info, {.history = 10}) {}

 protected:
  static constexpr std::uint32_t kBaud = 115200;

  // By which number the original names the device, and what the number means.
  [[nodiscard]] virtual Result<DeviceAddress> numbered(std::int32_t number) const = 0;

 private:
  Result<DeviceAddress> address() const {
    const std::string text = this->text("device");
    return text.empty() ? numbered(integer("serialDev")) : DeviceAddress::parse(text);
  }

  Result<DeviceOptions> device() const override {
    const auto where = address();
    if (!where) return where.error();
    return DeviceOptions{.address = *where, .baud = kBaud, .record = text("record")};
  }

  Result<std::unique_ptr<Hokuyo>> make_dialogue() override {
    const auto where = address();
    if (!where) return where.error();
    HokuyoSettings settings{
        .start = integer("start"),
        .end = integer("end"),
        .cluster = integer("cluster"),
        .baud = where->baud(kBaud),
        .has_rate = where->kind == TransportKind::kSerial || where->kind == TransportKind::kPty,
        .intensities = integer("intensity") != 0,
        .serial_number = text("serialNumber"),
        .only_listen = is_recording()};
    if (settings.end < settings.start) return refused("end must not be before start");
    const std::int32_t angle = integer("startAngle");
    if (angle != kHokuyoStartAngle) settings.start_angle = angle * std::numbers::pi / 180;
    set_period(std::chrono::milliseconds(100));
    return std::make_unique<Hokuyo>(settings);
  }
};

}  // namespace rack::device
