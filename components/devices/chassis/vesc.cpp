#include "components/devices/chassis/vesc.h"

#include <array>
#include <cmath>
#include <numbers>

#include "rack/devices/stream_buffer.h"

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr Duration kVescTick = 100ms;
constexpr double kVescTurn = 2 * std::numbers::pi;
constexpr double kRpm = kVescTurn / 60;  // rad/s
constexpr int kStepsOfElectricTurn = 6;  // tachometer steps

}  // namespace

void Vesc::send(VescPacket packet, std::int32_t value, Output& out, Time deadline) const {
  std::array<std::byte, 4> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<std::byte>(static_cast<std::uint32_t>(value) >> 8 * (3 - i));
  out.send_before(deadline, bytes, vesc_id(settings_.node, packet));
}

void Vesc::start(Time now, Output&) {
  clear();
  tachometer_.reset();
  next_ = now + kVescTick;
}

bool Vesc::on_frame(const Arrival& frame, Output&) {
  if ((frame.id & can::kExtended) == 0 || (frame.id & (can::kRemote | can::kError)) != 0 ||
      (frame.id & 0xFF) != settings_.node)
    return false;
  const auto bytes = frame.bytes;
  const std::uint32_t packet = (frame.id & ~can::kExtended) >> 8;
  if (bytes.size() < 8) return false;
  if (packet == static_cast<std::uint32_t>(VescPacket::kStatus1)) {
    const double velocity =
        big_endian<std::int32_t>(bytes) * kRpm / static_cast<double>(settings_.pole_pairs);
    // Without a tachometer, the position is integrated from the speed.
    if (settings_.task == MotorTask::kTurns && !tachometer_ && state_.measured != tims::kNever)
      state_.position +=
          velocity * std::chrono::duration<double>(frame.last - state_.measured).count();
    state_.velocity = velocity;
    state_.measured = frame.last;
  } else if (packet == static_cast<std::uint32_t>(VescPacket::kStatus4) &&
             settings_.task == MotorTask::kPositions) {
    constexpr double kUnit = kVescTurn / 360 / 50;
    state_.position = big_endian<std::int16_t>(bytes, 6) * kUnit;
  } else if (packet == static_cast<std::uint32_t>(VescPacket::kStatus5)) {
    if (settings_.task == MotorTask::kTurns) on_tachometer(big_endian<std::int32_t>(bytes));
    state_.volts = big_endian<std::int16_t>(bytes, 4) / 10.0;
  }
  return true;
}

void Vesc::on_tachometer(std::int32_t count) {
  if (tachometer_) {
    const auto steps = static_cast<std::int32_t>(static_cast<std::uint32_t>(count) -
                                                 static_cast<std::uint32_t>(*tachometer_));
    state_.position += steps * kVescTurn / (kStepsOfElectricTurn * settings_.pole_pairs);
  }
  tachometer_ = count;
}

void Vesc::on_timeout(Time now, Output&) {
  if (next_ > now) return;
  next_ = now + kVescTick;
  if (state_.measured != tims::kNever && now - state_.measured > kSilenceMax)
    fail("has stopped sending its status");
}

void Vesc::command(double target, Time now, Output& out) {
  const Time deadline = now + kCommandHolds;
  if (settings_.task == MotorTask::kTurns) {
    send(VescPacket::kSetRpm,
         static_cast<std::int32_t>(std::lround(target / kRpm * settings_.pole_pairs)), out,
         deadline);
    return;
  }
  constexpr double kUnit = 1e6;
  double degrees = std::fmod(target / kVescTurn * 360, 360);
  if (degrees < 0) degrees += 360;
  send(VescPacket::kSetPosition, static_cast<std::int32_t>(std::lround(degrees * kUnit)), out,
       deadline);
}

void Vesc::stand(Output& out) const {
  if (settings_.task == MotorTask::kTurns) send(VescPacket::kSetRpm, 0, out);
  send(VescPacket::kSetCurrent, 0, out);
}

void Vesc::stop(Output& out) {
  stand(out);
  next_ = tims::kNever;
}

}  // namespace rack::device
