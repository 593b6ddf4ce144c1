#include "components/devices/chassis/roomba_robot.h"

#include <array>
#include <vector>

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr Duration kFrames = 15ms;

// Number of data bytes of an opcode; empty for unknown opcodes.
std::optional<std::size_t> arguments_of(int opcode, std::span<const std::byte> rest) {
  switch (opcode) {
    case 0x80:
    case 0x82:
    case 0x83:
    case 0x84:
    case 0x8F:
      return 0;
    case 0x8C: {  // a song: its number, its length, and two bytes a note
      constexpr std::size_t kNotesMax = 16;
      const std::size_t notes = rest.size() < 2 ? 0 : std::to_integer<std::size_t>(rest[1]);
      return notes > kNotesMax ? std::nullopt : std::optional(2 + 2 * notes);
    }
    case 0x81:
    case 0x8A:
    case 0x8D:
    case 0x8E:
    case 0x96:
      return 1;
    case 0x89:
    case 0x91:
      return 4;
    case 0x94:
      return rest.empty() ? 1 : 1 + std::to_integer<std::size_t>(rest[0]);
    default:
      return {};
  }
}

}  // namespace

void RoombaEmulator::start(Time, Output& out) {
  started_ = in_control_ = false;
  next_frame_ = tims::kNever;
  received_.clear();
  out.set_baud(model_ == RoombaModel::kRoomba ? 57600 : 115200);
}

void RoombaEmulator::on_arrival(const Arrival& arrival, Output& out) {
  received_.add(arrival);
  body_.step(arrival.last);
  while (received_.size() > 0) {
    const auto bytes = received_.bytes();
    const auto arguments = arguments_of(std::to_integer<int>(bytes[0]), bytes.subspan(1));
    if (arguments && bytes.size() < 1 + *arguments) return;
    if (arguments) on_command(bytes.first(1 + *arguments), arrival.last, out);
    received_.consume(arguments ? 1 + *arguments : 1);
  }
}

void RoombaEmulator::on_command(std::span<const std::byte> bytes, Time now, Output& out) {
  const int opcode = std::to_integer<int>(bytes[0]);
  if (opcode == 0x80) {
    started_ = true;
    in_control_ = false;
  }
  if (!started_) return;
  constexpr std::array<std::uint32_t, 12> kRates = {300,   600,   1200,  2400,  4800,  9600,
                                                    14400, 19200, 28800, 38400, 57600, 115200};
  if (opcode == 0x81 && std::to_integer<std::size_t>(bytes[1]) < kRates.size())
    out.set_baud(kRates[std::to_integer<std::size_t>(bytes[1])]);
  // CONTROL of a Roomba (SAFE of a Create 2), or FULL: both move on command. The original's driver
  // sends CONTROL only.
  if (opcode >= 0x82 && opcode <= 0x84) in_control_ = true;
  if (opcode == 0x8E) send_sensors(out);
  if (opcode == 0x94) next_frame_ = now + kFrames;
  if (opcode == 0x96) next_frame_ = tims::kNever;
  if (!in_control_) return;
  if (opcode == 0x8A) motors_ = std::to_integer<int>(bytes[1]);
  if (opcode == 0x91)
    body_.set_targets(big_endian<std::int16_t>(bytes, 3), big_endian<std::int16_t>(bytes, 1));
  if (opcode != 0x89) return;
  const double speed = big_endian<std::int16_t>(bytes, 1);
  const int radius = big_endian<std::int16_t>(bytes, 3);
  if (radius == -0x8000 || radius == 0x7FFF || radius == 0) {
    body_.set_targets(speed, speed);
  } else if (std::abs(radius) == 1) {
    body_.set_targets(-radius * speed, radius * speed);
  } else {
    const double half = body_.track() / 2 / radius;
    body_.set_targets(speed * (1 - half), speed * (1 + half));
  }
}

void RoombaEmulator::send_sensors(Output& out) {
  const double left = body_.left_distance() - reported_left_;
  const double right = body_.right_distance() - reported_right_;
  const int distance = static_cast<int>(std::lround((left + right) / 2));
  const int turn = static_cast<int>(std::lround((right - left) / 2));
  reported_left_ += distance - turn;
  reported_right_ += distance + turn;
  std::vector<std::byte> bytes(12);
  bytes[0] = std::byte{bumps};
  bytes[7] = std::byte{overcurrents};
  append_big(bytes, static_cast<std::int16_t>(distance));
  append_big(bytes, static_cast<std::int16_t>(turn));
  bytes.push_back(std::byte{0});
  append_big(bytes, static_cast<std::int16_t>(16000));  // mV
  bytes.resize(26);
  out.send(bytes);
}

void RoombaEmulator::on_timeout(Time now, Output& out) {
  if (now < next_frame_) return;
  next_frame_ += kFrames;
  body_.step(now);
  send_frame(out);
}

void RoombaEmulator::send_frame(Output& out) {
  std::vector<std::byte> bytes{std::byte{0x13}, std::byte{0}};
  for (const std::uint8_t id : kCreate2Packets) {
    bytes.push_back(static_cast<std::byte>(id));
    const double distance = id == 43 ? body_.left_distance() : body_.right_distance();
    const int value = id == 7    ? bumps
                      : id == 14 ? overcurrents
                      : id == 22 ? 16000
                      : id == 43 || id == 44
                          ? static_cast<int>(std::floor(distance / kCreate2MillimetresOfCount))
                          : 0;
    if (create2_packet_size(id) == 2)
      append_big(bytes, static_cast<std::int16_t>(value));
    else
      bytes.push_back(static_cast<std::byte>(value));
  }
  bytes[1] = static_cast<std::byte>(bytes.size() - 2);
  unsigned sum = 0;
  for (const std::byte byte : bytes) sum += std::to_integer<unsigned>(byte);
  bytes.push_back(static_cast<std::byte>(0x100 - (sum & 0xFF)));
  out.send(bytes);
}

}  // namespace rack::device
