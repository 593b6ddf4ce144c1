#include "components/devices/chassis/pioneer.h"

#include <numbers>
#include <string_view>
#include <vector>

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr Duration kPioneerCycle = 100ms;

void send_framed(std::span<const std::byte> body, Output& out) {
  std::vector<std::byte> bytes{std::byte{0xFA}, std::byte{0xFB},
                               static_cast<std::byte>(body.size() + 2)};
  bytes.insert(bytes.end(), body.begin(), body.end());
  const unsigned sum = p2os_checksum(body);
  bytes.push_back(static_cast<std::byte>(sum >> 8));
  bytes.push_back(static_cast<std::byte>(sum));
  out.send(bytes);
}

// 1B: the argument is a size below zero. Otherwise it is a number of 16 bits with its sign, which
// the original's driver sends for turns to the right.
int argument_of(std::span<const std::byte> body) {
  if (body.size() < 4) return 0;
  if (body[1] == std::byte{0x1B}) return -static_cast<int>(little_endian<std::uint16_t>(body, 2));
  return little_endian<std::int16_t>(body, 2);
}

}  // namespace

void PioneerEmulator::start(Time now, Output&) {
  last_received_ = now;
  if (opened_) next_packet_ = now + kPioneerCycle;
}

void PioneerEmulator::on_arrival(const Arrival& arrival, Output& out) {
  packets_.add(arrival);
  P2osPackets::Packet packet;
  while (packets_.next(packet)) {
    last_received_ = arrival.last;
    body_.step(arrival.last);
    if (!packet.body.empty()) on_command(packet.body, arrival.last, out);
  }
}

void PioneerEmulator::on_command(std::span<const std::byte> body, Time now, Output& out) {
  const int number = std::to_integer<int>(body[0]);
  if (!opened_ && number == synced_ && number <= 2 && body.size() == 1 && synced_ < 3) {
    std::vector<std::byte> answer{body.begin(), body.end()};
    if (number == 2)
      for (const char c : std::string_view("Emulated\0Pioneer\0p3dx\0", 22))
        answer.push_back(static_cast<std::byte>(c));
    synced_ = number + 1;
    send_framed(answer, out);
    return;
  }
  if (!opened_ && number == 0 && body.size() == 1) {  // SYNC 0 restarts the sequence
    synced_ = 1;
    send_framed(body, out);
    return;
  }
  const int value = argument_of(body);
  switch (static_cast<P2osCommand>(number)) {
    case P2osCommand::kOpen:
      if (synced_ == 3 && !opened_) {
        opened_ = true;
        next_packet_ = now + kPioneerCycle;
      }
      break;
    case P2osCommand::kClose:
      opened_ = enabled_ = false;
      synced_ = 0;
      next_packet_ = tims::kNever;
      break;
    case P2osCommand::kEnable:
      enabled_ = value != 0;
      break;
    case P2osCommand::kVelocity:
      speed_ = value;
      break;
    case P2osCommand::kTurn:
      turn_ = value;
      break;
    case P2osCommand::kEncoder:
      encoders_ = value != 0;
      break;
    case P2osCommand::kSonar:
      sonar_ = value != 0;
      break;
    default:
      break;
  }
  apply();
}

void PioneerEmulator::apply() {
  if (!opened_ || !enabled_) {
    speed_ = turn_ = 0;
  }
  const double turn = turn_ * std::numbers::pi / 180 * body_.track() / 2;
  body_.set_targets(speed_ - turn, speed_ + turn);
}

void PioneerEmulator::on_timeout(Time now, Output& out) {
  if (now < next_packet_) return;
  next_packet_ += kPioneerCycle;
  if (now - last_received_ >= kWatchdog) {
    speed_ = turn_ = 0;
    apply();
  }
  body_.step(now);
  send_state(out);
  if (encoders_) send_encoders(out);
}

void PioneerEmulator::send_state(Output& out) {
  std::vector<std::byte> body{std::byte{body_.stands() ? std::uint8_t{0x32} : std::uint8_t{0x33}}};
  append_little(body,
                static_cast<std::int16_t>(static_cast<int>(std::lround(body_.pose().x)) & 0x7FFF));
  append_little(body,
                static_cast<std::int16_t>(static_cast<int>(std::lround(-body_.pose().y)) & 0x7FFF));
  append_little(body, static_cast<std::int16_t>(static_cast<int>(
                          std::lround(-body_.pose().rho * 4096 / (2 * std::numbers::pi)))));
  append_little(body, static_cast<std::int16_t>(static_cast<int>(std::lround(body_.left()))));
  append_little(body, static_cast<std::int16_t>(static_cast<int>(std::lround(body_.right()))));
  body.push_back(std::byte{125});  // 12.5 V
  for (int i = 0; i < 3; ++i)
    append_little(body, static_cast<std::int16_t>(0));  // stall and bumpers, control, flags
  body.push_back(std::byte{0});                         // compass
  const int sonars = sonar_ ? 2 : 0;
  body.push_back(static_cast<std::byte>(sonars));
  for (int i = 0; i < sonars; ++i) {
    body.push_back(static_cast<std::byte>(3 + i));
    append_little(body, static_cast<std::int16_t>(1000 * (i + 1)));
  }
  append_little(body, static_cast<std::int16_t>(0));
  for (int i = 0; i < 3; ++i) body.push_back(std::byte{0});
  send_framed(body, out);
}

void PioneerEmulator::send_encoders(Output& out) {
  std::vector<std::byte> body{std::byte{0x90}};
  for (const double distance : {body_.left_distance(), body_.right_distance()}) {
    const auto ticks = static_cast<std::int32_t>(std::llround(distance * kTicksOfMillimetre));
    append_little(body, static_cast<std::int16_t>(ticks));
    append_little(body, static_cast<std::int16_t>(ticks >> 16));
  }
  send_framed(body, out);
}

}  // namespace rack::device
