#include "components/devices/scanners/rplidar_packets.h"

#include <cstring>
#include <numbers>

namespace rack::device {
namespace {

constexpr std::byte kRplidarPacketBegin{0xA5};
constexpr std::byte kBeginOfAnswer{0x5A};
constexpr std::size_t kAnswerHead = 7;
constexpr std::size_t kAnswerMax = 256;
constexpr std::size_t kCapsuleHead = 4;  // sum, angle
constexpr std::uint8_t kHasPayload = 0x80;
constexpr std::uint32_t kSizeMask = 0x3FFF'FFFF;
constexpr unsigned kAngleMask = 0x7FFF;
constexpr double kRplidarPacketTurn = 2 * std::numbers::pi;
// A single point has no checksum: so many consecutive valid ones are required.
constexpr std::size_t kPointsInStep = 4;

std::size_t size_of(std::uint8_t type) {
  switch (type) {
    case rplidar::kPoints:
      return 5;
    case rplidar::kPairs:
    case rplidar::kDense:
      return 84;
    case rplidar::kTriples:
      return 132;
    default:
      return 0;
  }
}

constexpr int kPointsOfPairs = 32;
constexpr int kPointsOfTriples = 96;
constexpr int kPointsOfDense = 40;

int points_of(std::uint8_t type) {
  return type == rplidar::kPairs     ? kPointsOfPairs
         : type == rplidar::kTriples ? kPointsOfTriples
                                     : kPointsOfDense;
}

unsigned value(std::byte byte) { return std::to_integer<unsigned>(byte); }

// XOR of all bytes, computed eight bytes at a time.
unsigned sum_of(std::span<const std::byte> bytes) {
  std::uint64_t sum = 0;
  for (; bytes.size() >= sizeof sum; bytes = bytes.subspan(sizeof sum)) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data(), sizeof word);
    sum ^= word;
  }
  for (const std::byte byte : bytes) sum ^= std::to_integer<std::uint64_t>(byte);
  for (unsigned half = 32; half >= 8; half /= 2) sum ^= sum >> half;
  return sum & 0xFF;
}

bool is_point(std::span<const std::byte> bytes) {
  const bool starts = (value(bytes[0]) & 1) != 0;
  const bool starts_not = (value(bytes[0]) & 2) != 0;
  const unsigned angle = little_endian<std::uint16_t>(bytes, 1);
  constexpr unsigned kTurnOf64 = 360 * 64;
  return starts != starts_not && (angle & 1) != 0 && angle >> 1 < kTurnOf64 + 64;
}

bool is_capsule(std::span<const std::byte> bytes) {
  if (value(bytes[0]) >> 4 != 0xA || value(bytes[1]) >> 4 != 0x5) return false;
  const unsigned sum = (value(bytes[0]) & 0xF) | (value(bytes[1]) & 0xF) << 4;
  return sum == sum_of(bytes.subspan(2));
}

constexpr double kDegree = std::numbers::pi / 180;

double first_angle(std::span<const std::byte> capsule) {
  return (little_endian<std::uint16_t>(capsule, 2) & kAngleMask) * (kDegree / 64);
}

// The laser is mounted beside the receiver, so the angle of a triple deviates to the left by a term
// 98361 / distance in 1/4 mm.
constexpr std::int32_t kOffsetOver = 98361;
constexpr std::int32_t kNearest = 50;  // mm
constexpr std::size_t kOffsets = kOffsetOver / (4 * kNearest) + 1;
constexpr std::array<double, kOffsets> triple_offsets() {
  std::array<double, kOffsets> table{};
  for (std::size_t i = 0; i < kOffsets; ++i) {
    const auto k = static_cast<double>(i);
    table[i] = 8 * kDegree - (64 * k + k * k * k / 98304) / 65536;
  }
  return table;
}

double triple_offset(std::int32_t distance) {
  static constexpr auto kTable = triple_offsets();
  constexpr double kNear = 7.5 * kDegree;
  // Integer division takes three times as long; rounded down, the result is the same.
  constexpr float kOver = kOffsetOver / 4.0F;
  if (distance < kNearest) return kNear;
  return kTable[static_cast<std::size_t>(
      static_cast<std::int32_t>(kOver / static_cast<float>(distance)))];
}

struct Scale {
  std::int32_t offset;
  int shift;
};
constexpr Scale scale_from(std::int32_t from, std::int32_t distance, int shift) {
  return {.offset = distance - from * (1 << shift), .shift = shift};
}
// The scales start at 0, 512, 1280, 1792 and 3328: the highest four of the twelve bits select one.
constexpr std::array<Scale, 16> make_scales() {
  std::array<Scale, 16> scales{};
  for (std::size_t i = 0; i < scales.size(); ++i)
    scales.at(i) = i < 2    ? scale_from(0, 0, 0)
                   : i < 5  ? scale_from(512, 1 << 9, 1)
                   : i < 7  ? scale_from(1280, 1 << 11, 2)
                   : i < 13 ? scale_from(1792, 1 << 12, 3)
                            : scale_from(3328, 1 << 14, 4);
  return scales;
}

RplidarScaled scaled(std::uint32_t bits) {
  static constexpr auto kScales = make_scales();
  const Scale& found = kScales[bits >> 8 & 0xF];
  return {.distance = found.offset + static_cast<std::int32_t>(bits << found.shift),
          .shift = found.shift};
}

constexpr std::int32_t sign_extended(std::uint32_t bits) {
  return static_cast<std::int32_t>(bits << 22) >> 22;
}

// Decodes the second or third point of a triple from its difference to a neighbour.
std::int32_t predicted(std::int32_t difference, const RplidarScaled& near) {
  constexpr std::int32_t kNone = 0x1FF;
  constexpr std::int32_t kNoneEither = -0x200;
  if (difference == kNone || difference == kNoneEither) return 0;
  return std::max(0, near.distance + difference * (1 << near.shift));
}

}  // namespace

void append_rplidar(std::vector<std::byte>& out, std::uint8_t command,
                    std::span<const std::byte> payload) {
  const std::size_t begin = out.size();
  out.push_back(kRplidarPacketBegin);
  out.push_back(static_cast<std::byte>(command));
  if ((command & kHasPayload) == 0) return;
  out.push_back(static_cast<std::byte>(payload.size()));
  out.insert(out.end(), payload.begin(), payload.end());
  out.push_back(static_cast<std::byte>(sum_of(std::span(out).subspan(begin))));
}

void append_rplidar_answer(std::vector<std::byte>& out, std::uint8_t type, std::uint32_t size,
                           bool many) {
  out.push_back(kRplidarPacketBegin);
  out.push_back(kBeginOfAnswer);
  const std::uint32_t size_and_mode = size | (many ? 1U << 30 : 0);
  for (int i = 0; i < 4; ++i) out.push_back(static_cast<std::byte>(size_and_mode >> 8 * i));
  out.push_back(static_cast<std::byte>(type));
}

void seal_rplidar_capsule(std::span<std::byte> capsule) {
  const unsigned sum = sum_of(capsule.subspan(2));
  capsule[0] = static_cast<std::byte>(0xA0 | (sum & 0xF));
  capsule[1] = static_cast<std::byte>(0x50 | sum >> 4);
}

RplidarScaled rplidar_scaled(std::uint32_t bits) { return scaled(bits); }

void RplidarPackets::clear() {
  buffer_.clear();
  stream_ = 0;
  used_ = 0;
  is_in_step_ = follows_ = false;
}

bool RplidarPackets::next(RplidarPacket& packet) {
  buffer_.consume(std::exchange(used_, 0));
  while (buffer_.size() > 0) {
    const auto bytes = buffer_.bytes();
    // A measurement may begin with the same bytes as an answer. Therefore measurements are tried
    // first while synchronised, and answers are tried first otherwise.
    What what = stream_ != 0 && is_in_step_ ? take_measurement(bytes, packet) : What::kSkip;
    if (what == What::kSkip) what = take_answer(bytes, packet);
    if (what == What::kSkip && stream_ != 0 && !is_in_step_) what = take_measurement(bytes, packet);
    packet.began = buffer_.time_of(0);
    if (what == What::kPacket) return true;
    if (what == What::kNothing) return false;
    if (used_ > 0) {
      buffer_.consume(std::exchange(used_, 0));
    } else {
      buffer_.consume(1);
      lost_ += stream_ != 0 ? 1U : 0U;
    }
  }
  return false;
}

// Returns kSkip if the bytes are not an answer, or, with used_ set, if measurements begin here.
RplidarPackets::What RplidarPackets::take_answer(std::span<const std::byte> bytes,
                                                 RplidarPacket& packet) {
  if (bytes[0] != kRplidarPacketBegin) return What::kSkip;
  if (bytes.size() >= 2 && bytes[1] != kBeginOfAnswer) return What::kSkip;
  if (bytes.size() < kAnswerHead) return What::kNothing;
  const std::uint32_t size_and_mode = little_endian<std::uint32_t>(bytes, 2);
  const auto type = static_cast<std::uint8_t>(bytes[6]);
  const std::size_t size = size_and_mode & kSizeMask;
  const bool many = size_and_mode >> 30 == 1;
  if (many && size > 0 && size == size_of(type)) {
    stream_ = type;
    size_ = size;
    is_in_step_ = true;  // the first measurement follows immediately
    follows_ = false;
    used_ = kAnswerHead;
    return What::kSkip;
  }
  const bool is_known = type == rplidar::kInfoAnswer || type == rplidar::kHealthAnswer ||
                        type == rplidar::kConfigurationAnswer;
  if (many || !is_known || size == 0 || size > kAnswerMax) return What::kSkip;
  if (bytes.size() < kAnswerHead + size) return What::kNothing;
  packet.type = type;
  packet.data = bytes.subspan(kAnswerHead, size);
  used_ = kAnswerHead + size;
  stream_ = 0;
  return What::kPacket;
}

bool RplidarPackets::is_measurement(std::span<const std::byte> bytes) const {
  return stream_ == rplidar::kPoints ? is_point(bytes) : is_capsule(bytes.first(size_));
}

RplidarPackets::What RplidarPackets::take_measurement(std::span<const std::byte> bytes,
                                                      RplidarPacket& packet) {
  const std::size_t needed =
      stream_ == rplidar::kPoints && !is_in_step_ ? kPointsInStep * size_ : size_;
  if (bytes.size() < needed) return What::kNothing;
  for (std::size_t at = 0; at < needed; at += size_) {
    if (is_measurement(bytes.subspan(at))) continue;
    is_in_step_ = follows_ = false;
    return What::kSkip;
  }
  is_in_step_ = true;
  packet.type = stream_;
  packet.data = bytes.first(size_);
  packet.follows = std::exchange(follows_, true);
  used_ = size_;
  return What::kPacket;
}

void RplidarPoints::decode(const RplidarPacket& packet, TurningScan& scan) {
  if (packet.type == rplidar::kPoints) {
    decode_point(packet, scan);
    return;
  }
  constexpr Duration kGap = std::chrono::seconds(1);
  const Duration took = packet.began - before_time_;
  if (packet.follows && before_size_ == packet.data.size() && before_type_ == packet.type &&
      took >= Duration(0) && took < kGap) {
    const int points = points_of(packet.type);
    first_ = first_angle(before_);
    const double next = first_angle(packet.data);
    step_ = (next - first_ + (next < first_ ? kRplidarPacketTurn : 0)) / points;
    // A packet is sent after its last point was measured.
    step_time_ = took / points;
    began_ = before_time_ - took + step_time_;
    if (packet.type == rplidar::kPairs) decode_pairs(scan);
    if (packet.type == rplidar::kTriples) decode_triples(packet.data, scan);
    if (packet.type == rplidar::kDense) decode_dense(scan);
  }
  std::memcpy(before_.data(), packet.data.data(), std::min(packet.data.size(), before_.size()));
  before_size_ = packet.data.size();
  before_type_ = packet.type;
  before_time_ = packet.began;
}

void RplidarPoints::decode_point(const RplidarPacket& packet, TurningScan& scan) {
  const unsigned quality = value(packet.data[0]) >> 2;
  const double angle = (little_endian<std::uint16_t>(packet.data, 1) >> 1) * (kDegree / 64);
  const unsigned quarters = little_endian<std::uint16_t>(packet.data, 3);
  scan.add(angle, static_cast<i32>(quarters / 4), static_cast<i32>(quality), packet.began);
}

void RplidarPoints::decode_pairs(TurningScan& scan) const {
  constexpr std::size_t kPair = 5;
  std::array<LadarPoint, kPointsOfPairs> points;
  const auto put = [&](std::size_t point, unsigned distance_and_offset, unsigned offsets) {
    const unsigned offset = (offsets & 0xF) | (distance_and_offset & 3) << 4;
    points[point] = {.angle = angle_of(point, offset * (kDegree / 8)),
                     .distance = static_cast<i32>(distance_and_offset >> 2)};
  };
  for (std::size_t point = 0; point < points.size(); point += 2) {
    const std::size_t at = kCapsuleHead + kPair * (point / 2);
    const unsigned offsets = value(before_[at + 4]);
    put(point, little_endian<std::uint16_t>(before_, at), offsets);
    put(point + 1, little_endian<std::uint16_t>(before_, at + 2), offsets >> 4);
  }
  scan.add(points, began_, step_time_);
}

void RplidarPoints::decode_triples(std::span<const std::byte> next, TurningScan& scan) const {
  constexpr std::size_t kTriples = kPointsOfTriples / 3;
  constexpr std::uint32_t kDistanceMask = 0xFFF;
  std::array<LadarPoint, kPointsOfTriples> points;
  std::uint32_t cabin = little_endian<std::uint32_t>(before_, kCapsuleHead);
  RplidarScaled own = scaled(cabin & kDistanceMask);
  const auto put = [&](std::size_t point, std::int32_t distance) {
    points[point] = {.angle = angle_of(point, triple_offset(distance)), .distance = distance};
  };
  for (std::size_t triple = 0; triple < kTriples; ++triple) {
    const std::uint32_t cabin_after =
        triple + 1 < kTriples
            ? little_endian<std::uint32_t>(before_, kCapsuleHead + 4 * (triple + 1))
            : little_endian<std::uint32_t>(next, kCapsuleHead);
    const RplidarScaled after = scaled(cabin_after & kDistanceMask);
    const RplidarScaled& base = own.distance == 0 && after.distance != 0 ? after : own;
    put(3 * triple, own.distance);
    put(3 * triple + 1, predicted(sign_extended(cabin >> 12), base));
    put(3 * triple + 2, predicted(sign_extended(cabin >> 22), after));
    cabin = cabin_after;
    own = after;
  }
  scan.add(points, began_, step_time_);
}

void RplidarPoints::decode_dense(TurningScan& scan) const {
  std::array<LadarPoint, kPointsOfDense> points;
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = {.angle = angle_of(i),
                 .distance = little_endian<std::uint16_t>(before_, kCapsuleHead + 2 * i)};
  scan.add(points, began_, step_time_);
}

}  // namespace rack::device
