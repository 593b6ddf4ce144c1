// Bytes to the dialogues with range finders, in pieces of any size: none of them fails, and every
// scan can be sent.
#include <cmath>
#include <memory>

#include "components/devices/scan3d/http_get.h"
#include "components/devices/scan3d/ouster.h"
#include "components/devices/scan3d/velodyne.h"
#include "components/devices/scanners/hokuyo.h"
#include "components/devices/scanners/ibeo.h"
#include "components/devices/scanners/ibeo_lux.h"
#include "components/devices/scanners/ld19.h"
#include "components/devices/scanners/lms200.h"
#include "components/devices/scanners/rplidar.h"
#include "components/devices/scanners/sick_cola.h"
#include "components/devices/scanners/sick_compact.h"
#include "components/devices/scanners/sick_s.h"
#include "tests/fuzz/finite.h"

namespace {

using namespace rack::device;

struct Nobody : Output {
  void send(std::span<const std::byte>, std::uint32_t) override {}
};

void check(const rack::LadarData& scan) {
  tims::fuzz::require(scan.points.size() <= decltype(rack::LadarData::points)::kMax);
  tims::fuzz::require_finite(scan);
  for (const rack::LadarPoint& point : scan.points) tims::fuzz::require(point.distance >= 0);
}

void check(const rack::Scan3dData& scan) {
  tims::fuzz::require_finite(scan);
  tims::fuzz::require(scan.points.size() <= rack::kScan3dPointsMax);
  tims::fuzz::require(static_cast<std::size_t>(scan.pointNum) == scan.points.size());
  tims::fuzz::require(scan.pointNum == scan.scanNum * scan.scanPointNum);
}

// For a scanner that detects objects as well.
template <class Dialog>
void check_others(Dialog&) {}
template <>
void check_others(IbeoLux& scanner) {
  rack::ObjRecogData boxes;
  rack::ObjRecogData contours;
  Time recorded;
  if (!scanner.take_objects(boxes, contours, recorded)) return;
  tims::fuzz::require_finite(boxes);
  tims::fuzz::require_finite(contours);
}

template <class Data = rack::LadarData, class Dialog>
void talk(Dialog dialogue, std::span<const std::byte> bytes, std::size_t piece) {
  Nobody nobody;
  Time now(std::chrono::seconds(1));
  Data scan;
  Time recorded;
  dialogue.start(now, nobody);
  while (!bytes.empty()) {
    const auto part = bytes.first(std::min(piece, bytes.size()));
    bytes = bytes.subspan(part.size());
    now += std::chrono::milliseconds(5);
    dialogue.on_arrival({.bytes = part, .first = now, .last = now, .id = 0x701}, nobody);
    while (dialogue.take(scan, recorded)) check(scan);
    check_others(dialogue);
    if (dialogue.next_timeout() <= now) dialogue.on_timeout(now, nobody);
    if (dialogue.failure()) dialogue.start(now, nobody);
  }
}

// A small scanner: two columns per datagram, two beams.
constexpr std::string_view kMetadata =
    R"({"beam_altitude_angles": [3, -3], "beam_azimuth_angles": [1, -1],
 "columns_per_frame": 8, "columns_per_packet": 2, "pixels_per_column": 2,
 "udp_profile_lidar": "RNG19_RFL8_SIG16_NIR16"})";

void talk_ouster(std::span<const std::byte> bytes) {
  const auto metadata = OusterMetadata::parse(kMetadata);
  talk<rack::Scan3dData>(Ouster(*metadata, {.sectors = 2}), bytes, metadata->layout.packet_bytes());
}

// Decoded metadata of a scanner can be used.
void read_metadata(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto metadata = OusterMetadata::parse(text);
  if (!metadata) return;
  const std::vector<std::byte> packet(metadata->layout.packet_bytes());
  talk<rack::Scan3dData>(Ouster(*metadata, {}), packet, packet.size());
}

void read_page(std::span<const std::byte> bytes, std::size_t piece) {
  Nobody nobody;
  HttpGet get("scanner", "/");
  get.start({}, nobody);
  while (!bytes.empty()) {
    const auto part = bytes.first(std::min(piece, bytes.size()));
    bytes = bytes.subspan(part.size());
    get.on_arrival({.bytes = part}, nobody);
  }
  get.on_closed();
  tims::fuzz::require(get.is_done() != get.failure().has_value());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const auto bytes = std::as_bytes(std::span(data, size)).subspan(2);
  const std::size_t piece = 1U + data[1];
  switch (data[0] % 16) {
    case 0:
      talk(Hokuyo({.only_listen = true}), bytes, piece);
      break;
    case 1:
      talk(Hokuyo({}), bytes, piece);
      break;
    case 2:
      talk(Rplidar({.only_listen = true}), bytes, piece);
      break;
    case 3:
      talk(Rplidar({}), bytes, piece);
      break;
    case 4:
      talk(Ld19({.only_listen = true}), bytes, piece);
      break;
    case 5:
      talk(Ibeo({.only_listen = true}), bytes, 8);
      break;
    case 6:
      talk(Ibeo({}), bytes, 8);
      break;
    case 7:
      talk(IbeoLux({}), bytes, piece);
      break;
    case 8:
      talk<rack::Scan3dData>(Velodyne({.sectors = 36}), bytes, velodyne::kBytes);
      break;
    case 9:
      talk_ouster(bytes);
      break;
    case 10:
      read_metadata(bytes);
      break;
    case 11:
      read_page(bytes, piece);
      break;
    case 12:
      talk(SickCola({}), bytes, piece);
      break;
    case 13:
      talk(Lms200({}), bytes, piece);
      break;
    case 14:
      talk(SickS({}), bytes, piece);
      break;
    default:
      talk(SickCompact({}), bytes, bytes.size());
      break;
  }
  return 0;
}
