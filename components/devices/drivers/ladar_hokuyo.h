// Base of the drivers of Hokuyo range finders: everything except the address of the scanner.
#pragma once

#include <numbers>

#include "components/devices/scanners/hokuyo.h"
#include "rack/devices/driver.h"

namespace rack::device {

inline constexpr std::int32_t kHokuyoStartAngle = 120;  // deg, default of the original

inline constexpr std::array<ParameterInfo, 6> kHokuyoParameters = {{
    {"start", 44, "first measured step", 0, 9999},
    {"end", 725, "last measured step", 0, 9999},
    {"cluster", 3, "steps combined into one point", 1, 99},
    {"startAngle", kHokuyoStartAngle,
     "angle of the first step to the right [deg]; 120: as reported by a SCIP 2 scanner", -360, 360},
    {"intensity", 0, "1: also measure intensities (not supported by all scanners)", 0, 1},
    {"serialNumber", "", "required serial number of the scanner; empty: any"},
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

  // The address for a number of the original's parameter serialDev.
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
