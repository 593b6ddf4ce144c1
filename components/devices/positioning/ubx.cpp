#include "components/devices/positioning/ubx.h"

#include <cstring>
#include <numbers>

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr std::byte kSync1{0xB5};
constexpr std::byte kSync2{0x62};
constexpr std::byte kDollar{'$'};
constexpr Duration kUbxPatience = 2s;  // maximum time to complete a frame

std::uint16_t fletcher(std::span<const std::byte> bytes) {
  unsigned a = 0;
  unsigned b = 0;
  for (const std::byte byte : bytes) {
    a += std::to_integer<unsigned>(byte);
    b += a;
  }
  return static_cast<std::uint16_t>((a & 0xFF) | (b & 0xFF) << 8);
}

// The index at which the next frame or sentence may begin.
std::size_t find_beginning(std::span<const std::byte> bytes) {
  std::size_t at = 0;
  while (at < bytes.size() && bytes[at] != kSync1 && bytes[at] != kDollar) ++at;
  return at;
}

}  // namespace

void append_ubx(std::vector<std::byte>& out, std::uint8_t class_id, std::uint8_t number,
                std::span<const std::byte> payload) {
  out.push_back(kSync1);
  out.push_back(kSync2);
  const std::size_t begin = out.size();
  out.push_back(static_cast<std::byte>(class_id));
  out.push_back(static_cast<std::byte>(number));
  out.push_back(static_cast<std::byte>(payload.size()));
  out.push_back(static_cast<std::byte>(payload.size() >> 8));
  out.insert(out.end(), payload.begin(), payload.end());
  const std::uint16_t sum = fletcher(std::span(out).subspan(begin));
  out.push_back(static_cast<std::byte>(sum));
  out.push_back(static_cast<std::byte>(sum >> 8));
}

std::size_t ubx_value_size(std::uint32_t key) {
  constexpr std::array<std::size_t, 6> kSizes = {0, 1, 1, 2, 4, 8};
  const std::size_t code = key >> 28 & 7;
  return code < kSizes.size() ? kSizes[code] : 0;
}

bool decode_ubx_pvt(std::span<const std::byte> payload, GpsData& data, GpsMoment& moment) {
  constexpr std::size_t kOldSize = 84;  // size in the seventh generation
  constexpr double kDegree = std::numbers::pi / 180;
  if (payload.size() < kOldSize) return false;
  const auto u8_at = [&](std::size_t at) { return std::to_integer<unsigned>(payload[at]); };
  const auto i32_at = [&](std::size_t at) { return little_endian<std::int32_t>(payload, at); };
  const auto u32_at = [&](std::size_t at) { return little_endian<std::uint32_t>(payload, at); };
  const auto length_at = [&](std::size_t at) {
    return static_cast<i32>(std::min<std::uint32_t>(u32_at(at), INT32_MAX));
  };

  enum FixType : unsigned { kNone, kReckoned, k2d, k3d, kBoth, kOnlyTime };
  const unsigned type = u8_at(20);
  const unsigned flags = u8_at(21);
  const bool is_good = (flags & 1) != 0 && type >= kReckoned && type <= kBoth;
  data.mode = !is_good ? gps_mode::kInvalid : type == k2d ? gps_mode::k2d : gps_mode::k3d;
  if (is_good && (flags & 2) != 0) data.mode += gps_mode::kDifferential;
  if (is_good && type == kReckoned) data.mode += gps_mode::kEstimated;
  data.satelliteNum = static_cast<i32>(u8_at(23));
  data.longitude = i32_at(24) * 1e-7 * kDegree;
  data.latitude = i32_at(28) * 1e-7 * kDegree;
  data.altitude = i32_at(36);
  data.speed = i32_at(60);
  // Heading of the vehicle if the receiver has sensors to measure it, otherwise heading of motion.
  const bool has_heading = (flags & 0x20) != 0 && payload.size() >= 92;
  data.heading = heading_of(i32_at(has_heading ? 84 : 64) * 1e-5);
  data.pdop = static_cast<f32>(little_endian<std::uint16_t>(payload, 76) * 0.01);
  data.var = {.x = length_at(40), .y = length_at(40), .z = length_at(44)};
  data.var.rho = static_cast<f32>(std::min(180.0, u32_at(72) * 1e-5) * kDegree);

  moment = {};
  const unsigned second = u8_at(10);
  const auto day = days_since_1970(little_endian<std::uint16_t>(payload, 4), u8_at(6), u8_at(7));
  constexpr unsigned kDateAndTime = 3;
  if ((u8_at(11) & kDateAndTime) == kDateAndTime && day) {
    moment.utc = 24h * *day + std::chrono::hours(u8_at(8)) + std::chrono::minutes(u8_at(9)) +
                 std::chrono::seconds(second) + Duration(i32_at(16));
    moment.is_leap_second = second == 60;
  }
  // Rounds up times that are a few nanoseconds before a full second.
  data.utcTime =
      moment.utc ? std::chrono::floor<std::chrono::seconds>(*moment.utc + 1ms).count() : 0;
  return true;
}

void UbxStream::clear() {
  buffer_.clear();
  used_ = 0;
  is_part_ = false;
}

// A corrupted length would block the stream, so an incomplete frame is discarded after a timeout.
void UbxStream::add(const Arrival& arrival) {
  if (is_part_ && arrival.first - waits_since_ > kUbxPatience) {
    buffer_.consume(1);
    is_part_ = false;
  }
  buffer_.add(arrival);
}

UbxStream::What UbxStream::next(UbxFrame& frame, NmeaSentence& sentence) {
  buffer_.consume(std::exchange(used_, 0));
  while (buffer_.size() > 0) {
    buffer_.consume(find_beginning(buffer_.bytes()));
    if (buffer_.size() == 0) break;
    const bool is_frame = buffer_.bytes().front() == kSync1;
    const Found found = is_frame ? find_frame(frame) : find_sentence(sentence);
    if (found == Found::kWhole) {
      is_part_ = false;
      return is_frame ? What::kFrame : What::kSentence;
    }
    if (found == Found::kPart) {
      if (!is_part_) waits_since_ = buffer_.time_of(0);
      is_part_ = true;
      return What::kNothing;
    }
    buffer_.consume(1);
    is_part_ = false;
  }
  is_part_ = false;
  return What::kNothing;
}

UbxStream::Found UbxStream::find_frame(UbxFrame& frame) {
  const auto bytes = buffer_.bytes();
  if (bytes.size() < 2) return Found::kPart;
  if (bytes[1] != kSync2) return Found::kNone;
  if (bytes.size() < 6) return Found::kPart;
  const std::size_t size = little_endian<std::uint16_t>(bytes, 4);
  if (size > kPayloadMax) {
    ++broken_;
    return Found::kNone;
  }
  if (bytes.size() < size + kFrame) return Found::kPart;
  if (fletcher(bytes.subspan(2, size + 4)) != little_endian<std::uint16_t>(bytes, size + 6)) {
    ++broken_;
    return Found::kNone;
  }
  ++frames_;
  used_ = size + kFrame;
  frame = {.class_id = std::to_integer<std::uint8_t>(bytes[2]),
           .number = std::to_integer<std::uint8_t>(bytes[3]),
           .payload = bytes.subspan(6, size),
           .began = buffer_.time_of(0)};
  return Found::kWhole;
}

// A sentence ends after its checksum; a character that is not text ends it prematurely.
UbxStream::Found UbxStream::find_sentence(NmeaSentence& sentence) {
  constexpr std::size_t kChecksum = 3;
  const auto bytes = buffer_.bytes();
  const std::size_t most = std::min(bytes.size(), kSentenceMax);
  std::size_t at = 1;
  const auto is_text = [](std::byte byte) {
    return byte >= std::byte{0x20} && byte < std::byte{0x7F};
  };
  while (at < most && bytes[at] != std::byte{'*'} && bytes[at] != kDollar && is_text(bytes[at]))
    ++at;
  if (at == kSentenceMax) return Found::kNone;
  if (at < bytes.size() && bytes[at] != std::byte{'*'}) return Found::kNone;
  if (at + kChecksum > bytes.size()) return Found::kPart;
  const std::string_view line(reinterpret_cast<const char*>(bytes.data()), at + kChecksum);
  if (!parse_nmea(line, sentence)) return Found::kNone;
  ++sentences_;
  used_ = line.size();
  sentence.began = buffer_.time_of(0);
  return Found::kWhole;
}

}  // namespace rack::device
