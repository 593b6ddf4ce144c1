#include "components/devices/scanners/sick_compact.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "rack/devices/stream_buffer.h"

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kSickCompactMagic = 0x02020202;
constexpr std::uint32_t kScan = 1;
constexpr std::size_t kSickCompactHead = 32;
constexpr std::size_t kSickCompactCrc = 4;
constexpr std::size_t kSickCompactPointsMax = 2160;  // capacity of LadarData
constexpr std::size_t kBeamsMax = 16384;             // per turn
constexpr Duration kSickCompactFirstScanTime = 5s;
constexpr double kSickCompactTurn = 2 * std::numbers::pi;
// Azimuths of beams: zero, and units per radian.
constexpr int kAzimuthZero = 16384;
constexpr float kAzimuthUnits = 5215;

// Tables for computing the CRC of eight bytes at once: the first is for a single byte, table n for
// a byte followed by n bytes.
constexpr std::size_t kCrcAtOnce = 8;
using CrcTable = std::array<std::uint32_t, 256>;
constexpr std::array<CrcTable, kCrcAtOnce> crc_tables() {
  std::array<CrcTable, kCrcAtOnce> tables{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t crc = i;
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1) != 0 ? 0xEDB88320U : 0U);
    tables[0][i] = crc;
  }
  for (std::size_t follow = 1; follow < kCrcAtOnce; ++follow)
    for (std::size_t i = 0; i < 256; ++i) {
      const std::uint32_t before = tables[follow - 1][i];
      tables[follow][i] = before >> 8 ^ tables[0][before & 0xFF];
    }
  return tables;
}
constexpr std::array<CrcTable, kCrcAtOnce> kCrcTables = crc_tables();

// Reads little-endian values from the front. Missing values are read as 0 and make good() false.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <typename Number>
  Number take() {
    if (bytes_.size() < sizeof(Number)) good_ = false;
    if (!good_) return 0;
    const Number number = little_endian<Number>(bytes_);
    bytes_ = bytes_.subspan(sizeof(Number));
    return number;
  }
  float take_float() { return std::bit_cast<float>(take<std::uint32_t>()); }
  void skip(std::size_t count) {
    if (bytes_.size() < count) good_ = false;
    bytes_ = bytes_.subspan(std::min(count, bytes_.size()));
  }
  [[nodiscard]] bool good() const { return good_; }
  [[nodiscard]] std::span<const std::byte> rest() const { return bytes_; }

 private:
  std::span<const std::byte> bytes_;
  bool good_ = true;
};

constexpr std::size_t kLayersMax = 64;

struct Layer {
  std::uint64_t started = 0;
  std::uint64_t stopped = 0;
  float elevation = 0;
  float first = 0;  // azimuths
  float last = 0;
};

struct Module {
  std::uint64_t frame_number = 0;
  std::uint32_t serial_number = 0;
  std::size_t layers = 0;
  std::size_t beams = 0;
  std::size_t echoes = 0;
  std::array<Layer, kLayersMax> layer{};
  float factor = 1;
  std::size_t next_size = 0;
  bool has_distance = false;
  bool has_remission = false;
  bool has_flags = false;
  bool has_azimuth = false;

  [[nodiscard]] std::size_t echo_size() const {
    return (has_distance ? 2U : 0U) + (has_remission ? 2U : 0U);
  }
  [[nodiscard]] std::size_t beam_size() const {
    return echoes * echo_size() + (has_flags ? 1U : 0U) + (has_azimuth ? 2U : 0U);
  }
  [[nodiscard]] std::size_t most_level() const {
    std::size_t best = 0;
    for (std::size_t i = 1; i < layers; ++i)
      if (std::abs(layer[i].elevation) < std::abs(layer[best].elevation)) best = i;
    return best;
  }
};

bool take_head(Reader& reader, std::uint32_t version, Module& module) {
  reader.skip(sizeof(std::uint64_t));  // segment counter
  module.frame_number = reader.take<std::uint64_t>();
  module.serial_number = reader.take<std::uint32_t>();
  module.layers = reader.take<std::uint32_t>();
  module.beams = reader.take<std::uint32_t>();
  module.echoes = reader.take<std::uint32_t>();
  constexpr std::size_t kEchoesMax = 16;
  if (module.layers == 0 || module.layers > kLayersMax || module.beams > kBeamsMax ||
      module.echoes == 0 || module.echoes > kEchoesMax)
    return false;
  const auto layers = std::span(module.layer).first(module.layers);
  for (Layer& layer : layers) layer.started = reader.take<std::uint64_t>();
  for (Layer& layer : layers) layer.stopped = reader.take<std::uint64_t>();
  for (Layer& layer : layers) layer.elevation = reader.take_float();
  for (Layer& layer : layers) layer.first = reader.take_float();
  for (Layer& layer : layers) layer.last = reader.take_float();
  constexpr std::uint32_t kHasFactor = 4;
  module.factor = version >= kHasFactor ? reader.take_float() : 1;
  module.next_size = reader.take<std::uint32_t>();
  reader.skip(1);
  const auto of_echo = reader.take<std::uint8_t>();
  const auto of_beam = reader.take<std::uint8_t>();
  reader.skip(1);
  module.has_distance = (of_echo & 1) != 0;
  module.has_remission = (of_echo & 2) != 0;
  module.has_flags = (of_beam & 1) != 0;
  module.has_azimuth = (of_beam & 2) != 0;
  return reader.good() && std::isfinite(module.factor) && module.factor > 0;
}

// Decodes the beams after the header; `version` determines the order of flags and azimuth.
void take_beams(const Module& module, std::span<const std::byte> bytes, std::uint32_t version,
                CompactSegment& segment) {
  const std::size_t which = module.most_level();
  const Layer& layer = module.layer[which];
  const std::size_t size = module.beam_size();
  const std::size_t echoes = module.echoes * module.echo_size();
  const bool flags_first = version >= 4;
  const std::size_t flags_at = echoes + (flags_first || !module.has_azimuth ? 0 : 2);
  const std::size_t azimuth_at = echoes + (flags_first && module.has_flags ? 1 : 0);
  const float step =
      module.beams < 2 ? 0 : (layer.last - layer.first) / static_cast<float>(module.beams - 1);
  segment.beams.resize(module.beams);
  for (std::size_t i = 0; i < module.beams; ++i) {
    const auto from = bytes.subspan((i * module.layers + which) * size, size);
    CompactBeam& beam = segment.beams[i];
    const unsigned distance = module.has_distance ? little_endian<std::uint16_t>(from) : 0U;
    beam.distance = module.factor == 1 ? distance
                                       : static_cast<std::uint32_t>(std::min(
                                             1e9F, static_cast<float>(distance) * module.factor));
    beam.remission = module.has_remission
                         ? little_endian<std::uint16_t>(from, module.has_distance ? 2 : 0)
                         : std::uint16_t{0};
    beam.is_reflector = module.has_flags && (from[flags_at] & std::byte{1}) != std::byte{0};
    beam.azimuth =
        module.has_azimuth
            ? static_cast<float>(little_endian<std::uint16_t>(from, azimuth_at) - kAzimuthZero) /
                  kAzimuthUnits
            : layer.first + static_cast<float>(i) * step;
  }
  segment.frame_number = module.frame_number;
  segment.serial_number = module.serial_number;
  segment.started = layer.started;
  segment.stopped = layer.stopped;
  segment.elevation = layer.elevation;
}

bool is_finite(const Layer& layer) {
  return std::isfinite(layer.elevation) && std::abs(layer.first) < 100 &&
         std::abs(layer.last) < 100;
}

// Converts to clockwise, normalised to half a turn.
float clockwise(float azimuth) {
  return static_cast<float>(-std::remainder(static_cast<double>(azimuth), kSickCompactTurn));
}

}  // namespace

std::uint32_t crc32(std::span<const std::byte> bytes) {
  std::uint32_t crc = 0xFFFFFFFF;
  for (; bytes.size() >= kCrcAtOnce; bytes = bytes.subspan(kCrcAtOnce)) {
    const std::uint32_t first = crc ^ little_endian<std::uint32_t>(bytes);
    const auto second = little_endian<std::uint32_t>(bytes, 4);
    crc = 0;
    for (unsigned i = 0; i < 4; ++i)
      crc ^= kCrcTables[7 - i][first >> 8 * i & 0xFF] ^ kCrcTables[3 - i][second >> 8 * i & 0xFF];
  }
  for (const std::byte byte : bytes)
    crc = crc >> 8 ^ kCrcTables[0][(crc ^ std::to_integer<std::uint32_t>(byte)) & 0xFF];
  return ~crc;
}

CompactKind decode_compact(std::span<const std::byte> datagram, CompactSegment& segment) {
  if (datagram.size() < kSickCompactHead + kSickCompactCrc) return CompactKind::kBroken;
  const auto counted = datagram.first(datagram.size() - kSickCompactCrc);
  if (big_endian<std::uint32_t>(datagram) != kSickCompactMagic ||
      crc32(counted) != little_endian<std::uint32_t>(datagram, counted.size()))
    return CompactKind::kBroken;
  Reader reader(counted.subspan(sizeof(kSickCompactMagic)));
  if (reader.take<std::uint32_t>() != kScan) return CompactKind::kOther;
  segment.counter = reader.take<std::uint64_t>();
  segment.transmitted = reader.take<std::uint64_t>();
  const auto version = reader.take<std::uint32_t>();
  std::size_t size = reader.take<std::uint32_t>();
  if (version < 3 || version > 4) return CompactKind::kBroken;

  bool has_layer = false;
  auto rest = reader.rest();
  while (size > 0) {
    if (size > rest.size()) return CompactKind::kBroken;
    Module module;
    Reader head(rest.first(size));
    if (!take_head(head, version, module)) return CompactKind::kBroken;
    const auto beams = head.rest();
    if (beams.size() != module.beams * module.layers * module.beam_size())
      return CompactKind::kBroken;
    const Layer& layer = module.layer[module.most_level()];
    if (!is_finite(layer)) return CompactKind::kBroken;
    if (!has_layer || std::abs(layer.elevation) < std::abs(segment.elevation))
      take_beams(module, beams, version, segment);
    has_layer = true;
    rest = rest.subspan(size);
    size = module.next_size;
  }
  return has_layer ? CompactKind::kSegment : CompactKind::kOther;
}

SickCompact::SickCompact(const SickCompactSettings& settings)
    : settings_(settings), clock_(1us, std::uint64_t{1} << 62) {
  beams_.reserve(kBeamsMax);
}

void SickCompact::start(Time now, Output& /*out*/) {
  clear_failure();
  clock_.reset();
  is_ready_ = has_frame_ = has_scan_ = false;
  datagrams_ = broken_ = of_others_ = 0;
  segments_of_turn_ = 0;
  timer_.wait_until(now + kSickCompactFirstScanTime);
}

void SickCompact::on_arrival(const Arrival& arrival, Output& /*out*/) {
  ++datagrams_;
  switch (decode_compact(arrival.bytes, segment_)) {
    case CompactKind::kBroken:
      ++broken_;
      break;
    case CompactKind::kOther:
      break;
    case CompactKind::kSegment:
      if (settings_.serial_number != 0 && segment_.serial_number != settings_.serial_number)
        ++of_others_;
      else
        take_segment(arrival.last);
      break;
  }
}

// A turn is complete with its last segment if their number is known, otherwise with the first
// segment of the next turn.
void SickCompact::take_segment(Time arrived) {
  const bool is_late = has_frame_ && segment_.frame_number + 1 == frame_number_;
  if (is_late) return;
  if (has_frame_ && segment_.frame_number != frame_number_) {
    if (!is_finished_) finish_frame(arrived);
    // Fewer segments than before: some were lost, or, if this persists, the configuration has
    // changed.
    constexpr int kShortTurnsMax = 20;
    short_turns_ = segments_ < segments_of_turn_ ? short_turns_ + 1 : 0;
    if (segments_ > segments_of_turn_ || short_turns_ > kShortTurnsMax)
      segments_of_turn_ = segments_;
    has_frame_ = false;
  }
  if (!has_frame_) begin_frame();
  ++segments_;
  started_ = std::min(started_, segment_.started);
  stopped_ = std::max(stopped_, segment_.stopped);
  transmitted_ = segment_.transmitted;
  if (is_finished_) return;
  const std::size_t room = kBeamsMax - beams_.size();
  const auto beams = std::span(segment_.beams).first(std::min(room, segment_.beams.size()));
  beams_.insert(beams_.end(), beams.begin(), beams.end());
  if (segments_ == segments_of_turn_) finish_frame(arrived);
}

void SickCompact::begin_frame() {
  has_frame_ = true;
  is_finished_ = false;
  frame_number_ = segment_.frame_number;
  segments_ = 0;
  started_ = segment_.started;
  stopped_ = segment_.stopped;
  beams_.clear();
}

void SickCompact::finish_frame(Time arrived) {
  is_finished_ = true;
  if (!std::exchange(is_ready_, true)) return;  // the first turn is incomplete
  if (beams_.empty()) return;
  for (CompactBeam& beam : beams_) beam.azimuth = clockwise(beam.azimuth);
  std::ranges::sort(beams_, {}, &CompactBeam::azimuth);

  const std::size_t every = (beams_.size() + kSickCompactPointsMax - 1) / kSickCompactPointsMax;
  scan_.points.resize((beams_.size() + every - 1) / every);
  for (std::size_t i = 0; i < scan_.points.size(); ++i) {
    const CompactBeam& beam = beams_[i * every];
    LadarPoint& point = scan_.points[i];
    point.angle = beam.azimuth;
    point.distance = static_cast<i32>(beam.distance);
    point.intensity = beam.remission;
    point.type = beam.distance == 0  ? ladar_point::kInvalid
                 : beam.is_reflector ? ladar_point::kReflector
                                     : ladar_point::kUnknown;
  }
  scan_.startAngle = scan_.points.front().angle;
  scan_.endAngle = scan_.points.back().angle;
  scan_.maxRange = settings_.max_range;
  constexpr std::uint64_t kLongest = 1'000'000;  // us
  const std::uint64_t took = std::min(kLongest, stopped_ - started_);
  scan_.duration = static_cast<u32>((took + 500) / 1000);
  const std::uint64_t middle = started_ + took / 2;
  const bool has_times = transmitted_ >= middle && transmitted_ - middle < kLongest &&
                         transmitted_ < std::uint64_t{1} << 53;
  recorded_ = has_times ? clock_.to_host(transmitted_, arrived) -
                              1us * static_cast<std::int64_t>(transmitted_ - middle)
                        : arrived - 1us * static_cast<std::int64_t>(took / 2);
  has_scan_ = true;
  timer_.stop();
}

void SickCompact::on_timeout(Time now, Output& /*out*/) {
  if (!timer_.take_due(now)) return;
  fail(datagrams_ == 0 ? tims::Errc::kTimeout : tims::Errc::kMalformed, complaint());
}

std::string SickCompact::complaint() const {
  if (datagrams_ == 0)
    return "no datagrams received; configure the scanner to send its data to this host, on its web "
           "page, or, for a host 192.168.0.5, by (for c in 'sMN SetAccessMode 3 F4724744' 'sWN "
           "ScanDataEthSettings 1 +192 +168 +0 +5 +2115' 'sWN ScanDataFormat 2' 'sWN "
           "ScanDataEnable 1' 'sMN LMCstartmeas' 'sMN Run'; do printf '\\2%s\\3' \"$c\"; sleep 1; "
           "done) | nc SCANNER 2111";
  if (of_others_ > 0)
    return "data received from other scanners only, the last one has serial number " +
           std::to_string(segment_.serial_number);
  if (broken_ > 0)
    return "received data are not in format Compact; select it instead of MSGPACK on the scanner's "
           "web page";
  return "the scanner sends no scans, only data of its inertial unit";
}

bool SickCompact::take(LadarData& scan, Time& recorded) {
  if (!std::exchange(has_scan_, false)) return false;
  std::swap(scan, scan_);
  recorded = recorded_;
  return true;
}

}  // namespace rack::device
