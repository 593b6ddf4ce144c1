#include "components/devices/scan3d/ouster.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>

#include "rack/devices/stream_buffer.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;

constexpr double kOusterRadians = std::numbers::pi / 180;
constexpr Duration kOusterFirstWithin = std::chrono::seconds(3);

struct Profile {
  std::string_view name;
  OusterLayout layout;
};

constexpr std::array<Profile, 4> kProfiles = {{
    {"RNG19_RFL8_SIG16_NIR16_DUAL", {.pixel_bytes = 16, .reflectivity_at = 3}},
    {"RNG19_RFL8_SIG16_NIR16", {.pixel_bytes = 12, .reflectivity_at = 4}},
    {"RNG15_RFL8_NIR8",
     {.pixel_bytes = 4, .range_mask = 0x7FFF, .range_unit = 8, .reflectivity_at = 2}},
    {"LEGACY",
     {.head_bytes = 0,
      .column_head_bytes = 16,
      .pixel_bytes = 12,
      .column_foot_bytes = 4,
      .foot_bytes = 0,
      .range_mask = 0xFFFFF,
      .reflectivity_at = 4,
      .is_legacy = true}},
}};

// The value of a name anywhere in the text: each name occurs only once in the metadata of all
// firmware versions, but at different levels.
std::optional<std::string_view> value_of(std::string_view json, std::string_view name) {
  const std::string quoted = '"' + std::string(name) + '"';
  std::size_t at = json.find(quoted);
  if (at == std::string_view::npos) return std::nullopt;
  at = json.find_first_not_of(" \t\r\n", at + quoted.size());
  if (at == std::string_view::npos || json[at] != ':') return std::nullopt;
  at = json.find_first_not_of(" \t\r\n", at + 1);
  if (at == std::string_view::npos) return std::nullopt;
  const char begin = json[at];
  const std::size_t end = begin == '['   ? json.find(']', at)
                          : begin == '"' ? json.find('"', at + 1)
                                         : json.find_first_of(",}\r\n", at);
  if (end == std::string_view::npos) return std::nullopt;
  if (begin == '[' || begin == '"') return json.substr(at + 1, end - at - 1);
  return json.substr(at, end - at);
}

// Parses a list such as "1, 2.5, -3"; empty if it contains anything else.
std::optional<std::vector<double>> numbers_of(std::optional<std::string_view> text) {
  if (!text) return std::nullopt;
  std::vector<double> numbers;
  const char* at = text->data();
  const char* const end = at + text->size();
  while (true) {
    at = std::find_if(at, end,
                      [](char c) { return c != ' ' && c != '\n' && c != '\r' && c != '\t'; });
    if (at == end) return numbers;
    if (!numbers.empty() && *at++ != ',') return std::nullopt;
    at = std::find_if(at, end,
                      [](char c) { return c != ' ' && c != '\n' && c != '\r' && c != '\t'; });
    double number = 0;
    const auto [stop, bad] = std::from_chars(at, end, number);
    if (bad != std::errc() || !std::isfinite(number)) return std::nullopt;
    numbers.push_back(number);
    at = stop;
  }
}

Error missing(std::string_view name) {
  return {Errc::kMalformed,
          "metadata of the Ouster: " + std::string(name) +
              " is missing or invalid; read them from http://SCANNER/api/v1/sensor/metadata"};
}

std::optional<std::size_t> count_of(std::string_view json, std::string_view name,
                                    std::size_t most) {
  const auto numbers = numbers_of(value_of(json, name));
  if (!numbers || numbers->size() != 1 || numbers->front() < 1 ||
      numbers->front() > static_cast<double>(most))
    return std::nullopt;
  return static_cast<std::size_t>(numbers->front());
}

Result<OusterLayout> layout_of(std::string_view json) {
  const auto name = value_of(json, "udp_profile_lidar");
  const auto* const profile = std::ranges::find(kProfiles, name.value_or("LEGACY"), &Profile::name);
  if (profile == kProfiles.end())
    return Error(Errc::kInvalidArgument,
                 "the Ouster sends unsupported format " + std::string(*name) +
                     "; set its udp_profile_lidar to RNG19_RFL8_SIG16_NIR16 or RNG15_RFL8_NIR8");
  OusterLayout layout = profile->layout;
  const auto of_turn = count_of(json, "columns_per_frame", 4096);
  const auto of_packet = count_of(json, "columns_per_packet", 64);
  const auto beams = count_of(json, "pixels_per_column", 128);
  if (!of_turn) return missing("columns_per_frame");
  if (!of_packet) return missing("columns_per_packet");
  if (!beams) return missing("pixels_per_column");
  layout.columns_of_turn = *of_turn;
  layout.columns_of_packet = *of_packet;
  layout.beams = *beams;
  layout.last_column = *of_turn - 1;
  const auto window = numbers_of(value_of(json, "column_window"));
  if (window && window->size() == 2 && window->at(0) >= 0 && window->at(1) >= window->at(0) &&
      window->at(1) < static_cast<double>(*of_turn)) {
    layout.first_column = static_cast<std::size_t>(window->at(0));
    layout.last_column = static_cast<std::size_t>(window->at(1));
  }
  return layout;
}

}  // namespace

Result<OusterMetadata> OusterMetadata::parse(std::string_view json) {
  OusterMetadata metadata;
  const auto layout = layout_of(json);
  if (!layout) return layout.error();
  metadata.layout = *layout;
  for (const auto& [name, angles] : {std::pair("beam_altitude_angles", &metadata.altitudes),
                                     std::pair("beam_azimuth_angles", &metadata.azimuths)}) {
    const auto numbers = numbers_of(value_of(json, name));
    if (!numbers || numbers->size() != layout->beams) return missing(name);
    *angles = *numbers;
  }
  const auto origin = numbers_of(value_of(json, "lidar_origin_to_beam_origin_mm"));
  if (origin && origin->size() == 1) metadata.beam_origin = origin->front();
  // Row-major matrix; its last column is the position of the lasers.
  const auto transform = numbers_of(value_of(json, "lidar_to_sensor_transform"));
  constexpr std::size_t kHeight = 11;
  if (transform && transform->size() == 16) metadata.height = transform->at(kHeight);
  metadata.product = value_of(json, "prod_line").value_or("");
  return metadata;
}

OusterColumn ouster_column(const OusterLayout& layout, std::span<const std::byte> packet,
                           std::size_t column) {
  const auto bytes =
      packet.subspan(layout.head_bytes + column * layout.column_bytes(), layout.column_bytes());
  OusterColumn found{
      .time = little_endian<std::uint64_t>(bytes),
      .number = little_endian<std::uint16_t>(bytes, 8),
      .pixels = bytes.subspan(layout.column_head_bytes, layout.beams * layout.pixel_bytes)};
  if (layout.is_legacy) {
    found.frame = little_endian<std::uint16_t>(bytes, 10);
    found.is_valid = little_endian<std::uint32_t>(bytes, bytes.size() - 4) == 0xFFFFFFFF;
  } else {
    found.frame = little_endian<std::uint16_t>(packet, 2);
    found.is_valid = (little_endian<std::uint16_t>(bytes, 10) & 1) != 0;
  }
  found.is_valid = found.is_valid && found.number < layout.columns_of_turn;
  return found;
}

OusterPixel ouster_pixel(const OusterLayout& layout, const OusterColumn& column, std::size_t beam) {
  const std::size_t at = beam * layout.pixel_bytes;
  const auto pixel = little_endian<std::uint32_t>(column.pixels, at);
  return {
      .range = static_cast<i32>(pixel & layout.range_mask) * layout.range_unit,
      .reflectivity = std::to_integer<std::uint8_t>(column.pixels[at + layout.reflectivity_at])};
}

Ouster::Ouster(OusterMetadata metadata, const SpinSettings& settings)
    : metadata_(std::move(metadata)),
      scan_(settings),
      clock_(std::chrono::nanoseconds(1), std::numeric_limits<std::uint64_t>::max()) {
  const OusterLayout& layout = metadata_.layout;
  for (std::size_t i = 0; i < layout.beams; ++i) {
    const double up = metadata_.altitudes[i] * kOusterRadians;
    // Clockwise, as the columns.
    const double aside = metadata_.azimuths[i] * kOusterRadians;
    beams_.push_back({.level = static_cast<float>(std::cos(up)),
                      .down = static_cast<float>(-std::sin(up)),
                      .cos = static_cast<float>(std::cos(aside)),
                      .sin = static_cast<float>(std::sin(aside))});
  }
  for (std::size_t i = 0; i < layout.columns_of_turn; ++i) {
    // The frame of the lasers points backwards.
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) /
                             static_cast<double>(layout.columns_of_turn) +
                         std::numbers::pi + settings.direction;
    directions_.push_back(
        {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))});
  }
  constexpr i32 kFarthest = 0x7FFFF;
  scan_.set_device(kFarthest, 0);
}

void Ouster::start(Time now, Output&) {
  clear_failure();
  timer_.wait_until(now + kOusterFirstWithin);
  scan_.clear();
  clock_.reset();
  has_received_ = false;
}

void Ouster::on_timeout(Time now, Output&) {
  if (!timer_.take_due(now)) return;
  fail(tims::Errc::kTimeout,
       "no data of this Ouster at this port; check that its udp_dest is this host and the metadata "
       "are "
       "own?");
}

int Ouster::sector_of(std::size_t column) const {
  return static_cast<int>(column * static_cast<std::size_t>(scan_.settings().sectors) /
                          metadata_.layout.columns_of_turn);
}

void Ouster::on_arrival(const Arrival& arrival, Output&) {
  const OusterLayout& layout = metadata_.layout;
  const auto bytes = arrival.bytes;
  constexpr std::uint16_t kLidar = 1;
  if (bytes.size() != layout.packet_bytes() ||
      (!layout.is_legacy && little_endian<std::uint16_t>(bytes) != kLidar)) {
    ++broken_;
    return;
  }
  const OusterColumn last = ouster_column(layout, bytes, layout.columns_of_packet - 1);
  const auto ahead = static_cast<std::int16_t>(last.frame - frame_);
  constexpr std::int16_t kFew = 8;
  // A slightly older number is a datagram out of order; a much older one means that the scanner was
  // restarted.
  if (has_received_ && ahead < 0 && ahead > -kFew) return;
  has_received_ = true;
  timer_.stop();
  const Time end = clock_.to_host(last.time, arrival.last);
  for (std::size_t i = 0; i < layout.columns_of_packet; ++i) {
    const OusterColumn column = ouster_column(layout, bytes, i);
    if (!column.is_valid) continue;
    const auto before = static_cast<std::int64_t>(last.time - column.time);
    take_column(column, end - Duration(std::clamp<std::int64_t>(before, 0, 1'000'000'000)));
  }
}

void Ouster::take_column(const OusterColumn& column, Time when) {
  const OusterLayout& layout = metadata_.layout;
  const int sector = sector_of(column.number);
  const bool is_first = column.number == layout.first_column ||
                        (column.number > 0 && sector_of(column.number - 1U) != sector);
  frame_ = column.frame;
  const auto points = scan_.add(sector, is_first, when, layout.beams);
  const auto& [cos, sin] = directions_[column.number];
  const auto origin = static_cast<float>(metadata_.beam_origin);
  const auto height = static_cast<float>(metadata_.height);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const OusterPixel pixel = ouster_pixel(layout, column, i);
    const Beam& beam = beams_[i];
    const float along = static_cast<float>(pixel.range) - origin;
    const float level = along * beam.level;
    scan_.put(points[i], pixel.range, level * (cos * beam.cos - sin * beam.sin) + origin * cos,
              level * (sin * beam.cos + cos * beam.sin) + origin * sin, along * beam.down - height,
              static_cast<i16>(pixel.reflectivity));
  }
  const bool is_last =
      column.number == layout.last_column || sector_of(column.number + 1U) != sector;
  if (is_last) scan_.end_sector();
}

}  // namespace rack::device
