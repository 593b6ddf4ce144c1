#include "components/devices/chassis/er1_robot.h"

#include <cmath>

namespace rack::device {
namespace {

constexpr double kVelocityOfMillimetre = 764 * 256;

}  // namespace

void Er1Emulator::on_arrival(const Arrival& arrival, Output& out) {
  received_.add(arrival);
  body_.step(arrival.last);
  while (received_.size() >= 4) {
    const auto bytes = received_.bytes();
    const auto code = static_cast<Er1Code>(bytes[3]);
    const std::size_t size = 4 + er1_value_size(code);
    const bool is_head = bytes[0] <= std::byte{1} && bytes[2] == std::byte{0};
    if (is_head && bytes.size() < size) return;
    unsigned sum = 0;
    for (std::size_t i = 0; is_head && i < size; ++i) sum += std::to_integer<unsigned>(bytes[i]);
    if (!is_head || (sum & 0xFF) != 0) {
      received_.consume(1);
      continue;
    }
    on_command(bytes.first(size), out);
    received_.consume(size);
  }
}

void Er1Emulator::on_command(std::span<const std::byte> bytes, Output& out) {
  const auto wheel = std::to_integer<std::size_t>(bytes[0]);
  const auto code = static_cast<Er1Code>(bytes[3]);
  std::array<std::byte, 6> answer{};
  std::size_t size = 2;
  if (code == Er1Code::kReset) velocity_[wheel] = power_[wheel] = 0;
  if (code == Er1Code::kSetVelocity) velocity_[wheel] = big_endian<std::int32_t>(bytes, 4);
  if (code == Er1Code::kSetMotorCommand) power_[wheel] = big_endian<std::int16_t>(bytes, 4);
  if (code == Er1Code::kUpdate) in_force_[wheel] = velocity_[wheel];
  if (code == Er1Code::kGetActualPosition) {
    const double distance = wheel == 0 ? body_.right_distance() : -body_.left_distance();
    const auto count = static_cast<std::uint32_t>(std::llround(distance * kTicksOfMillimetre));
    for (std::size_t i = 0; i < 4; ++i)
      answer[2 + i] = static_cast<std::byte>(count >> 8 * (3 - i));
    size = 6;
  }
  unsigned sum = 0;
  for (const std::byte byte : answer) sum += std::to_integer<unsigned>(byte);
  answer[1] = static_cast<std::byte>(0x100 - (sum & 0xFF));
  body_.set_targets(power_[1] > 0 ? -in_force_[1] / kVelocityOfMillimetre : 0,
                    power_[0] > 0 ? in_force_[0] / kVelocityOfMillimetre : 0);
  out.send(std::span(answer).first(size));
}

}  // namespace rack::device
