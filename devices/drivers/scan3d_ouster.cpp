// Scan3dOuster: an Ouster scanner in the network.
#include <iterator>

#include "devices/drivers/scan3d_driver.h"
#include "devices/protocol/ouster.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(spin_parameters(std::array<ParameterInfo, 3>{{
    {"udpPort", 7502, "that the scanner sends to", 1, 65535},
    {"metadata", "", "file: curl http://SCANNER/api/v1/sensor/metadata >FILE", 0, 0, true},
    {"turnsPerSecond", 10, "as the scanner is set", 1, 20},
}}));

constexpr ModuleInfo kInfo{
    .program = "Scan3dOuster",
    .purpose = "Scans of space by an Ouster (OS-0, OS-1, OS-2, OS-Dome).",
    .class_id = tims::class_id::kScan3d,
    .parameters = kParameters,
};

Result<DeviceAddress> port(std::int32_t number) {
  return DeviceAddress{.kind = TransportKind::kUdp, .port = static_cast<std::uint16_t>(number)};
}

class Scan3dOuster : public Scan3dDriver<Ouster> {
 public:
  Scan3dOuster() : Scan3dDriver(kInfo) {}

 private:
  Result<DeviceOptions> device() const override { return device_by("udpPort", port, 0); }

  Result<std::unique_ptr<Ouster>> make_dialogue() override {
    const std::string path = text("metadata");
    std::ifstream file(path);
    if (!file) return tims::Error(tims::Errc::kSystem, "metadata: cannot read " + path);
    const std::string json{std::istreambuf_iterator<char>(file), {}};
    auto metadata = OusterMetadata::parse(json);
    if (!metadata)
      return tims::Error(metadata.error().code(), path + ": " + metadata.error().detail());
    if (metadata->layout.beams * metadata->layout.columns_of_turn >
        kScan3dPointsMax * static_cast<std::size_t>(integer("sectors")))
      return refused("a turn has more points than a message may have: set sectors");
    set_period(std::chrono::milliseconds(1000 / integer("turnsPerSecond") / integer("sectors")));
    return std::make_unique<Ouster>(std::move(*metadata), spin_settings());
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::Scan3dOuster scanner;
  return scanner.run(argc, argv);
}
