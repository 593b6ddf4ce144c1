#include "components/devices/scan3d/spinning_scanner.h"

#include <cmath>
#include <numbers>

namespace rack::device::emulator {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr Duration kVelodynePeriod(1'327'104);  // 24 times 55.296 us
constexpr Duration kOusterPeriod = std::chrono::microseconds(100'000) / 64;
constexpr double kTurnSeconds = 0.1;

template <typename Number>
void put(std::vector<std::byte>& bytes, std::size_t at, Number number) {
  for (std::size_t i = 0; i < sizeof number; ++i)
    bytes[at + i] = static_cast<std::byte>(number >> (8 * i));
}

}  // namespace

void SpinningScanner::start(Time now, Output&) {
  began_ = now;
  next_ = now + period_;
  sent_ = 0;
}

void SpinningScanner::on_timeout(Time now, Output& out) {
  while (next_ <= now) {
    packet_.clear();
    make(sent_, next_ - period_, packet_);
    out.send(packet_);
    ++sent_;
    next_ += period_;
  }
}

VelodyneScanner::VelodyneScanner(Sight sight)
    : SpinningScanner(kVelodynePeriod), sight_(std::move(sight)) {}

void VelodyneScanner::make(std::uint64_t index, Time began, std::vector<std::byte>& packet) {
  using namespace velodyne;
  const VelodyneLayout& layout = *velodyne_layout(static_cast<std::uint8_t>(VelodyneModel::kVlp16));
  packet.resize(kBytes);
  const double turn_us = kTurnSeconds * 1e6;
  const double packet_us = layout.sequence_us * 24;
  const double start_us = packet_us * static_cast<double>(index);
  constexpr double kFarthest = 65535;
  for (std::size_t block = 0; block < kBlocks; ++block) {
    const std::size_t at = block * kBlockBytes;
    const auto head_at = [&](double us) { return std::fmod(us, turn_us) / turn_us * kTurn; };
    const double since = start_us + 2 * layout.sequence_us * static_cast<double>(block);
    put(packet, at, std::uint16_t{0xEEFF});
    put(packet, at + 2, static_cast<std::uint16_t>(head_at(since)));
    for (std::size_t i = 0; i < kReturns; ++i) {
      const std::size_t sequence = i / layout.lasers.size();
      const std::size_t laser = i % layout.lasers.size();
      const double fired = since + layout.sequence_us * static_cast<double>(sequence) +
                           layout.firing_us * static_cast<double>(laser);
      const double angle = head_at(fired) / 100 * kRadians;
      const Time when = began + std::chrono::nanoseconds(std::llround((fired - start_us) * 1000));
      const double units =
          sight_(angle, layout.lasers[laser].elevation * kRadians, when) / layout.range_unit;
      put(packet, at + 4 + 3 * i,
          static_cast<std::uint16_t>(units > kFarthest ? 0 : units));  // 0: no echo
      packet[at + 6 + 3 * i] = std::byte{50};
    }
  }
  constexpr std::int64_t kHour = 3'600'000'000;
  const auto microseconds = began.time_since_epoch() / std::chrono::microseconds(1);
  put(packet, kBytes - 6, static_cast<std::uint32_t>(microseconds % kHour));
  packet[kBytes - 2] = std::byte{0x37};
  packet[kBytes - 1] = static_cast<std::byte>(VelodyneModel::kVlp16);
}

OusterScanner::OusterScanner(Sight sight)
    : SpinningScanner(kOusterPeriod),
      sight_(std::move(sight)),
      metadata_(*OusterMetadata::parse(metadata())) {}

std::string_view OusterScanner::metadata() {
  return R"({"prod_line": "OS-0-16", "lidar_mode": "1024x10",
 "beam_altitude_angles": [45, 39, 33, 27, 21, 15, 9, 3, -3, -9, -15, -21, -27, -33, -39, -45],
 "beam_azimuth_angles": [3, 1, -1, -3, 3, 1, -1, -3, 3, 1, -1, -3, 3, 1, -1, -3],
 "lidar_origin_to_beam_origin_mm": 27.67,
 "lidar_to_sensor_transform": [-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 36.18, 0, 0, 0, 1],
 "data_format": {"columns_per_frame": 1024, "columns_per_packet": 16, "pixels_per_column": 16,
  "column_window": [0, 1023], "udp_profile_lidar": "RNG19_RFL8_SIG16_NIR16"}})";
}

void OusterScanner::make(std::uint64_t index, Time began, std::vector<std::byte>& packet) {
  const OusterLayout& layout = metadata_.layout;
  packet.resize(layout.packet_bytes());
  put(packet, 0, std::uint16_t{1});
  const std::uint64_t packets_of_turn = layout.columns_of_turn / layout.columns_of_packet;
  put(packet, 2, static_cast<std::uint16_t>(index / packets_of_turn));
  const Duration of_column = kOusterPeriod / static_cast<std::int64_t>(layout.columns_of_packet);
  for (std::size_t c = 0; c < layout.columns_of_packet; ++c) {
    const std::size_t at = layout.head_bytes + c * layout.column_bytes();
    const std::size_t column = index % packets_of_turn * layout.columns_of_packet + c;
    const Time when = began + of_column * static_cast<std::int64_t>(c);
    put(packet, at, static_cast<std::uint64_t>(when.time_since_epoch().count()));
    put(packet, at + 8, static_cast<std::uint16_t>(column));
    put(packet, at + 10, std::uint16_t{1});
    const double head = 2 * std::numbers::pi * static_cast<double>(column) /
                            static_cast<double>(layout.columns_of_turn) +
                        std::numbers::pi;
    for (std::size_t i = 0; i < layout.beams; ++i) {
      const double angle = head + metadata_.azimuths[i] * kRadians;
      const double seen = sight_(angle, metadata_.altitudes[i] * kRadians, when);
      const double range = seen < kNothing ? seen : 0;  // 0: no echo
      const std::size_t pixel = at + layout.column_head_bytes + i * layout.pixel_bytes;
      put(packet, pixel, static_cast<std::uint32_t>(range));
      packet[pixel + layout.reflectivity_at] = std::byte{60};
    }
  }
}

void OusterPage::on_arrival(const Arrival& arrival, Output& out) {
  question_.append(reinterpret_cast<const char*>(arrival.bytes.data()), arrival.bytes.size());
  if (!question_.ends_with("\r\n\r\n")) return;
  const bool is_known = question_.starts_with("GET /api/v1/sensor/metadata ");
  question_.clear();
  const std::string_view body = is_known ? OusterScanner::metadata() : std::string_view();
  const std::string answer = (is_known ? "HTTP/1.1 200 OK" : "HTTP/1.1 404 Not Found") +
                             std::string("\r\nContent-Type: application/json\r\nContent-Length: ") +
                             std::to_string(body.size()) + "\r\n\r\n" + std::string(body);
  out.send(std::as_bytes(std::span(answer)));
}

}  // namespace rack::device::emulator
