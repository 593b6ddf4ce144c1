#include "components/devices/scanners/rplidar_emulator.h"

#include <array>
#include <cmath>
#include <numbers>

namespace rack::device::emulator {
namespace {

constexpr std::byte kBegin{0xA5};
constexpr double kOffset = 1;  // angle offset of the points of pairs, degrees
constexpr std::uint16_t kMode = 2;

int points_of(std::uint8_t type) {
  switch (type) {
    case rplidar::kPairs:
      return 32;
    case rplidar::kTriples:
      return 96;
    case rplidar::kDense:
      return 40;
    default:
      return 1;
  }
}

std::uint32_t size_of(std::uint8_t type) {
  return type == rplidar::kPoints ? 5 : type == rplidar::kTriples ? 132 : 84;
}

// Encodes a distance in twelve bits, rounded down.
std::uint32_t scaled(std::int32_t distance) {
  std::uint32_t bits = 0;
  for (std::uint32_t step = 2048; step > 0; step /= 2)
    if (rplidar_scaled(bits + step).distance <= distance) bits += step;
  return bits;
}

std::uint32_t difference(std::int32_t distance, const RplidarScaled& near) {
  constexpr std::int32_t kLargest = 510;
  constexpr std::uint32_t kNone = 0x1FF;
  const std::int32_t steps = (distance - near.distance) / (1 << near.shift);
  if (distance == 0 || std::abs(steps) > kLargest) return kNone;
  return static_cast<std::uint32_t>(steps) & 0x3FF;
}

// According to the manual: the smaller the distance, the more the beam deviates to the left.
double triple_offset(double distance) {
  if (distance < 50) return 7.5;
  const double k = std::floor(98361 / (4 * distance));
  return 8 - (64 * k + k * k * k / 98304) / 65536 * 180 / std::numbers::pi;
}

}  // namespace

void Rplidar::start(Time, Output& out) {
  is_broken_ = settings_.is_broken;
  type_ = 0;
  motor_ = 0;
  next_ = tims::kNever;
  waiting_.clear();
  out.set_baud(settings_.baud);
}

void Rplidar::on_arrival(const Arrival& arrival, Output& out) {
  waiting_.insert(waiting_.end(), arrival.bytes.begin(), arrival.bytes.end());
  while (!waiting_.empty()) {
    const std::size_t used = take_command(arrival.last, out);
    if (used == 0) return;
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(used));
  }
}

std::size_t Rplidar::take_command(Time now, Output& out) {
  if (waiting_[0] != kBegin) return 1;
  if (waiting_.size() < 2) return 0;
  const auto command = static_cast<std::uint8_t>(waiting_[1]);
  if (command < 0x80) {
    obey(command, {}, now, out);
    return 2;
  }
  if (waiting_.size() < 3) return 0;
  const std::size_t size = std::to_integer<std::size_t>(waiting_[2]);
  if (waiting_.size() < size + 4) return 0;
  std::byte sum{};
  for (std::size_t i = 0; i < size + 3; ++i) sum ^= waiting_[i];
  if (sum != waiting_[size + 3]) return 1;
  obey(command, std::span(waiting_).subspan(3, size), now, out);
  return size + 4;
}

void Rplidar::obey(std::uint8_t command, std::span<const std::byte> payload, Time now,
                   Output& out) {
  constexpr std::array<std::uint8_t, 15> kSerial = {0xC0, 0xDE, 1, 2, 3, 4, 5};
  std::vector<std::byte> data;
  switch (command) {
    case rplidar::kStop:
      type_ = 0;
      next_ = tims::kNever;
      break;
    case rplidar::kReset:
      is_broken_ = settings_.stays_broken;
      type_ = 0;
      next_ = tims::kNever;
      break;
    case rplidar::kInfo:
      append_little(data, settings_.model, 1);
      append_little(data, settings_.firmware, 2);
      append_little(data, 5, 1);
      for (const std::uint8_t byte : kSerial) append_little(data, byte, 1);
      append_little(data, settings_.serial_number, 1);
      answer(rplidar::kInfoAnswer, data, out);
      break;
    case rplidar::kHealth:
      append_little(data, is_broken_ ? 2 : 0, 1);
      append_little(data, is_broken_ ? 0x8001 : 0, 2);
      answer(rplidar::kHealthAnswer, data, out);
      break;
    case rplidar::kScan:
      if (!is_broken_) begin(rplidar::kPoints, now, out);
      break;
    case rplidar::kExpress:
      // Mode 0 is that of pairs; the requested mode is ignored.
      if (!is_broken_ && payload.size() == 5)
        begin(payload[0] == std::byte{} ? rplidar::kPairs : settings_.type, now, out);
      break;
    case rplidar::kConfiguration:
      if (payload.size() >= 4) answer_configuration(payload, out);
      break;
    case rplidar::kMotor:
      if (payload.size() == 2) motor_ = little_endian<std::uint16_t>(payload);
      break;
    default:
      break;
  }
}

void Rplidar::answer(std::uint8_t type, std::span<const std::byte> data, Output& out) {
  packet_.clear();
  append_rplidar_answer(packet_, type, static_cast<std::uint32_t>(data.size()), false);
  packet_.insert(packet_.end(), data.begin(), data.end());
  out.send(packet_);
}

void Rplidar::answer_configuration(std::span<const std::byte> payload, Output& out) {
  const std::uint32_t entry = little_endian<std::uint32_t>(payload);
  std::vector<std::byte> data;
  append_little(data, entry, 4);
  if (entry == rplidar::kTypicalMode)
    append_little(data, settings_.type == rplidar::kPairs ? 0 : kMode, 2);
  else if (entry == rplidar::kAnswerOfMode)
    append_little(data, settings_.type, 1);
  else if (entry == rplidar::kRangeOfMode)
    append_little(data, static_cast<std::uint32_t>(settings_.range * 256), 4);
  else
    return;
  answer(rplidar::kConfigurationAnswer, data, out);
}

void Rplidar::begin(std::uint8_t type, Time now, Output& out) {
  type_ = type;
  point_ = 0;
  packet_.clear();
  append_rplidar_answer(packet_, type, size_of(type), true);
  out.send(packet_);
  next_ = now + settings_.spin_up;
}

Duration Rplidar::packet_time() const {
  return Duration(std::chrono::seconds(1)) * points_of(type_) / settings_.points_a_second;
}

void Rplidar::on_timeout(Time now, Output& out) {
  if (next_ > now) return;
  packet_.clear();
  if (type_ == rplidar::kPoints)
    append_point();
  else if (type_ == rplidar::kPairs)
    append_pairs();
  else if (type_ == rplidar::kTriples)
    append_triples();
  else
    append_dense();
  out.send(packet_);
  point_ += static_cast<std::uint64_t>(points_of(type_));
  next_ += packet_time();
}

double Rplidar::angle_of(std::uint64_t point) const {
  const double turns_a_second = settings_.turns_a_minute / 60.0;
  return 360 * turns_a_second * static_cast<double>(point) / settings_.points_a_second;
}

// Points sent at next_ were measured until that time.
std::int32_t Rplidar::seen(double degrees, std::uint64_t point) const {
  const auto left = points_of(type_) - static_cast<std::int64_t>(point - point_);
  const Time when = next_ - Duration(std::chrono::seconds(1)) * left / settings_.points_a_second;
  const double distance = settings_.sight(degrees * std::numbers::pi / 180, 0, when);
  return distance > 1000 * settings_.range ? 0 : static_cast<std::int32_t>(std::lround(distance));
}

void Rplidar::append_point() {
  constexpr unsigned kQuality = 47;
  const double angle = std::fmod(angle_of(point_), 360);
  const bool begins = point_ == 0 || angle < std::fmod(angle_of(point_ - 1), 360);
  append_little(packet_, kQuality << 2 | (begins ? 1 : 2), 1);
  append_little(packet_, static_cast<std::uint32_t>(angle * 64) << 1 | 1, 2);
  append_little(packet_, static_cast<std::uint32_t>(4 * seen(angle, point_)), 2);
}

// Appends a placeholder of the sum, and the angle of the first point.
void Rplidar::append_head() {
  append_little(packet_, 0, 2);
  const double angle = std::fmod(angle_of(point_), 360);
  append_little(packet_, static_cast<std::uint32_t>(angle * 64) | (point_ == 0 ? 0x8000 : 0), 2);
}

void Rplidar::append_pairs() {
  constexpr auto kEighths = static_cast<std::uint32_t>(8 * kOffset);
  append_head();
  for (std::uint64_t i = 0; i < 32; i += 2) {
    for (std::uint64_t j = i; j < i + 2; ++j)
      append_little(packet_,
                    static_cast<std::uint32_t>(seen(angle_of(point_ + j) - kOffset, point_ + j))
                            << 2 |
                        kEighths >> 4,
                    2);
    append_little(packet_, (kEighths & 0xF) << 4 | (kEighths & 0xF), 1);
  }
  seal_rplidar_capsule(packet_);
}

void Rplidar::append_triples() {
  constexpr std::size_t kPoints = 97;  // including the first of the next packet
  std::array<std::int32_t, kPoints> distances{};
  for (std::size_t i = 0; i < kPoints; ++i) {
    double distance = 1000;
    for (int again = 0; again < 8; ++again)
      distance = seen(angle_of(point_ + i) - triple_offset(distance), point_ + i);
    distances[i] = static_cast<std::int32_t>(distance);
  }
  append_head();
  for (std::size_t i = 0; i + 1 < kPoints; i += 3) {
    const std::uint32_t own = scaled(distances[i]);
    const RplidarScaled near = rplidar_scaled(own);
    const RplidarScaled next = rplidar_scaled(scaled(distances[i + 3]));
    append_little(
        packet_,
        own | difference(distances[i + 1], near) << 12 | difference(distances[i + 2], next) << 22,
        4);
  }
  seal_rplidar_capsule(packet_);
}

void Rplidar::append_dense() {
  append_head();
  for (std::uint64_t i = 0; i < 40; ++i)
    append_little(packet_, static_cast<std::uint32_t>(seen(angle_of(point_ + i), point_ + i)), 2);
  seal_rplidar_capsule(packet_);
}

}  // namespace rack::device::emulator
