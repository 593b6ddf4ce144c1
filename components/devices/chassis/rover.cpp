#include "components/devices/chassis/rover.h"

namespace rack::device {
namespace {

using namespace std::chrono_literals;
using mavlink::Message;

constexpr Duration kRoverTick = 100ms;
constexpr std::uint16_t kRoverSetMode = 176;
constexpr std::uint16_t kRoverArm = 400;
constexpr std::uint16_t kRoverMessageInterval = 511;

}  // namespace

void RoverEmulator::start(Time now, Output&) { next_ = now + kRoverTick; }

void RoverEmulator::on_arrival(const Arrival& arrival, Output& out) {
  packets_.add(arrival);
  body_.step(arrival.last);
  while (packets_.next(packet_)) on_packet(packet_, arrival.last, out);
}

void RoverEmulator::on_packet(const mavlink::Packet& packet, Time now, Output& out) {
  if (packet.message == Message::kCommand && packet.number<std::uint8_t>(30) == kSystem) {
    const auto command = packet.number<std::uint16_t>(28);
    if (command == kRoverArm) armed_ = packet.real(0) != 0;
    if (command == kRoverSetMode) mode_ = static_cast<std::uint32_t>(packet.real(4));
    if (command == kRoverMessageInterval) ++intervals_;
    if (!armed_) body_.set_targets(0, 0);
    auto answer = writer(Message::kCommandAck);
    answer.put(command).put(std::uint8_t{0});
    out.send(answer.finish());
  }
  if (packet.message != Message::kSetPositionTarget || !armed_ || mode_ != kGuided) return;
  const double speed = packet.real(16) * 1000;
  const double turn = packet.real(44) * body_.track() / 2;
  body_.set_targets(speed + turn, speed - turn);
  commanded_ = now;
}

void RoverEmulator::on_timeout(Time now, Output& out) {
  if (now < next_) return;
  next_ = now + kRoverTick;
  body_.step(now);
  if (now - commanded_ > kVelocityTimeout) body_.set_targets(0, 0);
  if (tick_++ % 10 == 0) send_status(out);
  send_motion(now, out);
}

void RoverEmulator::send_status(Output& out) {
  auto heart = writer(Message::kHeartbeat);
  heart.put(mode_).put(std::uint8_t{10}).put(std::uint8_t{3});
  heart.put(static_cast<std::uint8_t>(armed_ ? 0x81 : 0x01)).put(std::uint8_t{4});
  heart.put(std::uint8_t{3});
  out.send(heart.finish());
  auto status = writer(Message::kSystemStatus);
  status.put(std::uint32_t{0}).put(std::uint32_t{0}).put(std::uint32_t{0});
  status.put(std::uint16_t{100}).put(std::uint16_t{12600});
  out.send(status.finish());
}

void RoverEmulator::send_motion(Time now, Output& out) {
  const auto boot = static_cast<std::uint32_t>(now.time_since_epoch() / 1ms);
  const double speed = (body_.left() + body_.right()) / 2000;
  const double turn = (body_.left() - body_.right()) / body_.track();
  const double heading = std::remainder(body_.pose().rho, 6.283185307179586);
  auto attitude = writer(Message::kAttitude);
  attitude.put(boot).put_real(0.01).put_real(-0.02).put_real(heading);
  attitude.put_real(0).put_real(0).put_real(turn);
  out.send(attitude.finish());
  auto local = writer(Message::kLocalPosition);
  local.put(boot).put_real(body_.pose().x / 1000).put_real(body_.pose().y / 1000).put_real(-0.5);
  local.put_real(speed * std::cos(heading)).put_real(speed * std::sin(heading)).put_real(0);
  out.send(local.finish());
  auto gps = writer(Message::kGpsRaw);
  gps.put(std::uint64_t{1700000000123456}).put(std::int32_t{523791234});
  gps.put(std::int32_t{97123456}).put(std::int32_t{55250}).put(std::uint16_t{121});
  gps.put(std::uint16_t{180}).put(std::uint16_t{150}).put(std::uint16_t{9000});
  gps.put(std::uint8_t{3}).put(std::uint8_t{11});
  out.send(gps.finish());
  if (!sends_odometry) return;
  auto odometry = writer(Message::kOdometry);
  odometry.put(std::uint64_t{boot} * 1000);
  odometry.put_real(body_.pose().x / 1000).put_real(body_.pose().y / 1000).put_real(-0.5);
  odometry.put_real(std::cos(heading / 2)).put_real(0).put_real(0).put_real(std::sin(heading / 2));
  odometry.put_real(speed).put_real(0).put_real(0).put_real(0).put_real(0).put_real(turn);
  for (int i = 0; i < 42; ++i) odometry.put_real(0);
  odometry.put(std::uint8_t{1}).put(std::uint8_t{12});
  out.send(odometry.finish());
}

}  // namespace rack::device
