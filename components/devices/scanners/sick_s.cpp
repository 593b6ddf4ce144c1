#include "components/devices/scanners/sick_s.h"

#include <numbers>

#include "rack/devices/device_clock.h"

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kUncounted = 4;  // leading zeros, not included in the size
constexpr std::size_t kSickSHead = 20;
constexpr std::size_t kSickSCrc = 2;
constexpr std::size_t kBlock = 4;  // BB BB 11 11
constexpr std::size_t kNewer = 4;  // bytes that newer versions exclude from the size
constexpr std::byte kCoordination{0xFF};
constexpr std::uint8_t kMaster = 0x07;
constexpr std::uint8_t kSlave = 0x08;
constexpr std::uint16_t kDistances = 0xBBBB;
constexpr std::uint16_t kFirstField = 0x1111;
constexpr double kStep = 0.5;  // degrees
constexpr i32 kMaxRange = 30000;
constexpr i32 kCodes = 10 * 0x1FF0;  // higher values are codes: dazzled, out of range
constexpr Duration kSickSFirstScanTime = 2s;

// Field of view of a device, degrees, and duration of a scan, ms.
struct FieldOfView {
  std::size_t values;
  double angle;
  u32 duration;
};
constexpr FieldOfView field_of(SickSDevice device) {
  return device == SickSDevice::kS300 ? FieldOfView{541, 270, 40} : FieldOfView{381, 190, 30};
}

constexpr std::array<std::uint16_t, 256> sick_s_crc_table() {
  std::array<std::uint16_t, 256> table{};
  for (unsigned i = 0; i < 256; ++i) {
    unsigned crc = i << 8;
    for (int bit = 0; bit < 8; ++bit) crc = crc << 1 ^ ((crc & 0x8000) != 0 ? 0x1021U : 0U);
    table[i] = static_cast<std::uint16_t>(crc);
  }
  return table;
}
constexpr std::array<std::uint16_t, 256> kCrcTable = sick_s_crc_table();

bool has_crc(std::span<const std::byte> whole) {
  if (whole.size() < kSickSHead + kBlock + kSickSCrc) return false;
  const auto counted = whole.subspan(kUncounted, whole.size() - kUncounted - kSickSCrc);
  return sick_s_crc(counted) == little_endian<std::uint16_t>(whole, whole.size() - kSickSCrc);
}

// Checks for six zeros, a size, FF and an address.
bool is_head(std::span<const std::byte> bytes) {
  for (std::size_t i = 0; i < 6; ++i)
    if (bytes[i] != std::byte{0}) return false;
  return bytes[8] == kCoordination;
}

}  // namespace

std::uint16_t sick_s_crc(std::span<const std::byte> bytes) {
  unsigned crc = 0xFFFF;
  for (const std::byte byte : bytes)
    crc = (crc << 8 & 0xFF00) ^ kCrcTable[crc >> 8 ^ std::to_integer<unsigned>(byte)];
  return static_cast<std::uint16_t>(crc);
}

void append_sick_s(std::vector<std::byte>& out, const SickSTelegram& telegram) {
  const std::size_t begin = out.size();
  const std::size_t counted = kSickSHead - kUncounted + telegram.blocks.size() + kSickSCrc;
  append_big(out, 0, 4);
  append_big(out, 0, 2);
  append_big(out, static_cast<std::uint32_t>(counted / 2), 2);
  out.push_back(kCoordination);
  out.push_back(static_cast<std::byte>(telegram.address));
  append_big(out, 0x0102, 2);
  append_big(out, 0, 2);
  append_big(out, telegram.scan_number, 4);
  append_big(out, telegram.scan_number & 0xFFFF, 2);
  out.insert(out.end(), telegram.blocks.begin(), telegram.blocks.end());
  const std::uint16_t crc = sick_s_crc(std::span(out).subspan(begin + kUncounted));
  out.push_back(static_cast<std::byte>(crc));
  out.push_back(static_cast<std::byte>(crc >> 8));
}

// Skips noise byte by byte.
bool SickSTelegrams::next(SickSTelegram& telegram) {
  buffer_.consume(std::exchange(used_, 0));
  while (buffer_.size() >= kSickSHead) {
    const auto bytes = buffer_.bytes();
    std::size_t size = kUncounted + 2 * std::size_t{big_endian<std::uint16_t>(bytes, 6)};
    if (!is_head(bytes) || size < kSickSHead + kBlock - kNewer || size > kTelegramMax) {
      buffer_.consume(1);
      continue;
    }
    if (bytes.size() < size) return false;
    if (!has_crc(bytes.first(size))) {
      size += kNewer;
      if (bytes.size() < size) return false;
      if (!has_crc(bytes.first(size))) {
        ++broken_;
        buffer_.consume(1);
        continue;
      }
    }
    const auto whole = bytes.first(size);
    telegram = {.address = std::to_integer<std::uint8_t>(whole[9]),
                .scan_number = big_endian<std::uint32_t>(whole, 14),
                .blocks = whole.subspan(kSickSHead, size - kSickSHead - kSickSCrc),
                .began = buffer_.time_of(0)};
    used_ = size;
    return true;
  }
  return false;
}

bool decode_sick_s_scan(const SickSTelegram& telegram, SickSDevice device, LadarData& scan) {
  const FieldOfView field = field_of(device);
  const auto blocks = telegram.blocks;
  if (blocks.size() != kBlock + 2 * field.values) return false;
  if (big_endian<std::uint16_t>(blocks) != kDistances ||
      big_endian<std::uint16_t>(blocks, 2) != kFirstField)
    return false;

  constexpr double kRadian = std::numbers::pi / 180;
  constexpr unsigned kCentimetres = 0x1FFF;
  constexpr unsigned kReflector = 1U << 13;
  const double right = field.angle / 2 * kRadian;
  scan.maxRange = kMaxRange;
  scan.duration = field.duration;
  scan.startAngle = static_cast<float>(-right);
  scan.endAngle = static_cast<float>(right);
  scan.points.resize(field.values);
  for (std::size_t i = 0; i < field.values; ++i) {
    // The scanner sends counterclockwise, so the order is reversed.
    const unsigned value = little_endian<std::uint16_t>(blocks, kBlock + 2 * i);
    const auto distance = static_cast<i32>(10 * (value & kCentimetres));
    const bool is_measured = distance > 0 && distance < kCodes;
    const bool is_reflector = is_measured && (value & kReflector) != 0;
    LadarPoint& point = scan.points[field.values - 1 - i];
    point.angle = static_cast<float>(right - static_cast<double>(i) * kStep * kRadian);
    point.distance = distance;
    point.type = !is_measured   ? ladar_point::kInvalid
                 : is_reflector ? ladar_point::kReflector
                                : ladar_point::kUnknown;
    point.intensity = is_reflector ? 1 : 0;
  }
  return true;
}

void SickS::start(Time now, Output& /*out*/) {
  clear_failure();
  telegrams_.clear();
  is_ready_ = has_scan_ = false;
  bytes_ = of_others_ = unknown_ = 0;
  timer_.wait_until(now + kSickSFirstScanTime);
}

void SickS::on_arrival(const Arrival& arrival, Output& /*out*/) {
  bytes_ += arrival.bytes.size();
  telegrams_.add(arrival);
  SickSTelegram telegram;
  while (telegrams_.next(telegram)) {
    if (telegram.address != (settings_.is_slave ? kSlave : kMaster)) {
      ++of_others_;
    } else if (!decode_sick_s_scan(telegram, settings_.device, scan_)) {
      ++unknown_;
    } else {
      has_scan_ = is_ready_ = true;
      timer_.stop();
      // The telegram is sent at the end of the scan; its middle was half a scan before.
      recorded_ = telegram.began - std::chrono::milliseconds(scan_.duration) / 2;
    }
  }
}

void SickS::on_timeout(Time now, Output& /*out*/) {
  if (!timer_.take_due(now)) return;
  fail(bytes_ == 0 ? tims::Errc::kTimeout : tims::Errc::kMalformed, complaint());
}

std::string SickS::complaint() const {
  if (bytes_ == 0)
    return "the scanner sends nothing; check its power and that continuous output is configured";
  if (unknown_ > 0)
    return "received data are not scans of this device; check devNumber (300 or 3000); continuous "
           "output must be configured to all distances of one field with a step of 0.5 degrees";
  if (of_others_ > 0)
    return std::string("only the other scanner of the EFI bus sends data; set EFIdev=") +
           (settings_.is_slave ? "0" : "1");
  return "received data cannot be decoded; check that the scanner's rate is " +
         std::to_string(settings_.baud) + " baud";
}

bool SickS::take(LadarData& scan, Time& recorded) {
  if (!std::exchange(has_scan_, false)) return false;
  std::swap(scan, scan_);
  recorded = recorded_;
  return true;
}

}  // namespace rack::device
