#include "components/devices/scanners/ld19.h"

#include <array>
#include <numbers>

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr std::byte kLd19Begin{0x54};
constexpr std::byte kVersionAndPoints{0x2C};
constexpr std::size_t kPointsAt = 6;
constexpr std::size_t kPointSize = 3;
constexpr std::size_t kLastAngleAt = 42;
constexpr std::size_t kTimeAt = 44;
constexpr i32 kLd19RangeMin = 20;
constexpr i32 kLd19RangeMax = 12'000;
// Includes the spin-up of the motor.
constexpr Duration kLd19SpinUp = 5s;

constexpr std::array<std::uint8_t, 256> ld19_crc_table() {
  constexpr unsigned kPolynomial = 0x4D;
  std::array<std::uint8_t, 256> table{};
  for (unsigned i = 0; i < table.size(); ++i) {
    unsigned crc = i;
    for (int bit = 0; bit < 8; ++bit) crc = crc << 1 ^ ((crc & 0x80) != 0 ? kPolynomial : 0);
    table[i] = static_cast<std::uint8_t>(crc);
  }
  return table;
}

}  // namespace

std::uint8_t ld19_crc(std::span<const std::byte> bytes) {
  static constexpr auto kTable = ld19_crc_table();
  std::uint8_t crc = 0;
  for (const std::byte byte : bytes) crc = kTable[crc ^ std::to_integer<std::uint8_t>(byte)];
  return crc;
}

void Ld19::start(Time now, Output& out) {
  clear_failure();
  buffer_.clear();
  clock_.reset();
  scan_.clear();
  scan_.set_range(kLd19RangeMin, kLd19RangeMax);
  packets_ = 0;
  if (!settings_.only_listen) out.set_baud(settings_.baud);
  timer_.wait_until(settings_.only_listen ? tims::kNever : now + kLd19SpinUp);
}

void Ld19::on_timeout(Time now, Output&) {
  if (!timer_.take_due(now)) return;
  fail(tims::Errc::kTimeout, "no complete turn of an LD06 or LD19 received at " +
                                 std::to_string(settings_.baud) +
                                 " baud; check its power and parameter model");
}

void Ld19::on_arrival(const Arrival& arrival, Output&) {
  buffer_.add(arrival);
  while (buffer_.size() >= kLd19Size) {
    const auto bytes = buffer_.bytes();
    if (bytes[0] != kLd19Begin || bytes[1] != kVersionAndPoints) {
      buffer_.consume(1);
      continue;
    }
    const auto packet = bytes.first(kLd19Size);
    if (ld19_crc(packet.first(kLd19Size - 1)) != std::to_integer<std::uint8_t>(packet.back())) {
      ++broken_;
      buffer_.consume(1);
      continue;
    }
    decode(packet, buffer_.time_of(0));
    buffer_.consume(kLd19Size);
    ++packets_;
    if (is_ready()) timer_.stop();
  }
}

void Ld19::decode(std::span<const std::byte> packet, Time came) {
  constexpr double kHundredth = std::numbers::pi / 180 / 100;
  constexpr double kTurn = 2 * std::numbers::pi;
  constexpr auto kGaps = static_cast<double>(kLd19Points - 1);
  const double speed = little_endian<std::uint16_t>(packet, 2) * (std::numbers::pi / 180);
  const double first = little_endian<std::uint16_t>(packet, 4) * kHundredth;
  const double last = little_endian<std::uint16_t>(packet, kLastAngleAt) * kHundredth;
  const double wide = last - first + (last < first ? kTurn : 0);
  const std::uint64_t counter = little_endian<std::uint16_t>(packet, kTimeAt);
  // The packet is sent after its last point was measured.
  const Time end = counter < kTimeEnd ? clock_.to_host(counter, came) : came;
  const double took = speed > 0 ? wide / speed : 0;  // s
  const Duration step_time(static_cast<std::int64_t>(1e9 * took / kGaps));
  const double step = wide / kGaps;
  std::array<LadarPoint, kLd19Points> points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t at = kPointsAt + kPointSize * i;
    points[i] = {.angle = static_cast<f32>(first + step * static_cast<double>(i)),
                 .distance = little_endian<std::uint16_t>(packet, at),
                 .intensity = std::to_integer<i32>(packet[at + 2])};
  }
  scan_.add(points, end - step_time * static_cast<std::int64_t>(kLd19Points - 1), step_time);
}

}  // namespace rack::device
