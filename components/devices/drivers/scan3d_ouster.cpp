// Scan3dOuster: driver of an Ouster scanner on the network.

#include "components/devices/drivers/scan3d_driver.h"
#include "components/devices/scan3d/http_get.h"
#include "components/devices/scan3d/ouster.h"
#include "components/files/whole_file.h"
#include "os/file.h"

namespace rack::device {
namespace {

constexpr std::size_t kMetadataMax = 1 << 20;  // those of 128 beams have 30 kB

constexpr auto kParameters = driver_parameters(spin_parameters(std::array<ParameterInfo, 4>{{
    {"udpPort", 7502, "UDP port to which the scanner sends", 1, 65535},
    {"scanner", "", "host name or address; its metadata are read by HTTP"},
    host_file(
        {"metadata", "", "metadata file: written if scanner is given, otherwise read (for play:)"}),
    {"turnsPerSecond", 10, "speed configured in the scanner [1/s]", 1, 20},
}}));

constexpr ModuleInfo kInfo{
    .program = "Scan3dOuster",
    .purpose = "3D scans of an Ouster (OS-0, OS-1, OS-2, OS-Dome).",
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
    const auto json = text("scanner").empty() ? read_metadata() : ask_scanner();
    if (!json) return json.error();
    auto metadata = OusterMetadata::parse(*json);
    if (!metadata) return metadata.error();
    if (auto kept = keep_metadata(*json); !kept) return kept.error();
    if (metadata->layout.beams * metadata->layout.columns_of_turn >
        kScan3dPointsMax * static_cast<std::size_t>(integer("sectors")))
      return refused("a turn has more points than a message can hold; increase sectors");
    set_period(std::chrono::milliseconds(1000 / integer("turnsPerSecond") / integer("sectors")));
    return std::make_unique<Ouster>(std::move(*metadata), spin_settings());
  }

  Result<std::string> read_metadata() const {
    const std::string path = text("metadata");
    if (path.empty())
      return refused("scanner is missing; example: --scanner=192.168.0.1; or set metadata");
    return tims::os::read_file(path, kMetadataMax);
  }

  // Called at each ON: the scanner may have been replaced or reconfigured.
  Result<std::string> ask_scanner() const {
    const std::string host = text("scanner");
    const bool has_port = host.find(':') != std::string::npos;
    const auto address = DeviceAddress::parse("tcp:" + host + (has_port ? "" : ":80"));
    if (!address) return address.error();
    HttpGet get(host, "/api/v1/sensor/metadata");
    auto device = Device::open({.address = *address}, get);
    if (!device) return without_page(device.error());
    while (!get.is_done()) {
      const auto waited = (*device)->wait(tims::kNever);
      if (!waited) get.on_closed();
      if (get.failure()) return without_page(*get.failure());
    }
    return get.body();
  }

  // Firmware before 2.2 does not have this page, but provides the same metadata on TCP port 7501.
  static tims::Error without_page(const tims::Error& error) {
    return {error.code(),
            error.detail() +
                "; with firmware before 2.2, write the metadata by: printf 'get_beam_intrinsics\\n"
                "get_lidar_intrinsics\\nget_lidar_data_format\\n' | nc -q 2 SCANNER 7501 >FILE"};
  }

  Result<void> keep_metadata(const std::string& json) const {
    const std::string path = text("metadata");
    if (path.empty() || text("scanner").empty()) return {};
    return write_file(path, json);
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::Scan3dOuster scanner;
  return scanner.run(argc, argv);
}
