#include "components/devices/chassis/odrive.h"

#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "base/text.h"
#include "rack/devices/stream_buffer.h"

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr Duration kOdriveTick = 50ms;
constexpr Duration kEncoderLate = 40ms;  // then encoder values are requested
constexpr Duration kCloseAgain = 500ms;
constexpr int kOdriveAttempts = 5;
// Larger values are not measurements.
constexpr float kTurnsMax = 1e7F;
constexpr float kTurnsEachSecondMax = 1e4F;
constexpr float kVoltsMax = 1e3F;
constexpr double kOdriveTurn = 2 * std::numbers::pi;

constexpr std::uint32_t kVelocityControl = 2;
constexpr std::uint32_t kPositionControl = 3;
constexpr std::uint32_t kPassThrough = 1;
constexpr std::uint32_t kTrapezoid = 5;

template <typename... Numbers>
std::array<std::byte, (sizeof(Numbers) + ...)> packed(Numbers... numbers) {
  std::array<std::byte, (sizeof(Numbers) + ...)> bytes{};
  std::size_t at = 0;
  const auto put = [&](auto number) {
    for (std::size_t i = 0; i < sizeof number; ++i)
      bytes[at++] = static_cast<std::byte>(static_cast<std::uint64_t>(number) >> 8 * i);
  };
  (put(numbers), ...);
  return bytes;
}

float real(std::span<const std::byte> bytes, std::size_t at) {
  return std::bit_cast<float>(little_endian<std::uint32_t>(bytes, at));
}

std::uint32_t raw(double value) { return std::bit_cast<std::uint32_t>(static_cast<float>(value)); }

}  // namespace

void Odrive::send(OdriveCommand command, std::span<const std::byte> bytes, Output& out,
                  Time deadline) const {
  out.send_before(deadline, bytes, odrive_id(node_, command));
}

void Odrive::ask(OdriveCommand command, Output& out) const {
  out.send({}, odrive_id(node_, command) | can::kRemote);
}

void Odrive::start(Time now, Output& out) {
  clear();
  axis_state_ = 0;
  last_heartbeat_ = tims::kNever;
  close_.reset();
  close_.wait_until(now);
  next_volts_ = now;
  next_ = now + kOdriveTick;
  send(OdriveCommand::kClearErrors, packed(std::uint8_t{0}), out);
}

void Odrive::close_loop(Time now, Output& out) {
  if (!close_.may_repeat(kOdriveAttempts))
    return fail("does not enter closed loop control; check its calibration");
  close_.sent(now, kCloseAgain);
  const bool turns = task_ == MotorTask::kTurns;
  send(OdriveCommand::kControllerMode,
       packed(turns ? kVelocityControl : kPositionControl, turns ? kPassThrough : kTrapezoid), out);
  if (turns) command(0, {}, out);
  send(OdriveCommand::kAxisState, packed(std::uint32_t{kClosedLoop}), out);
}

bool Odrive::on_frame(const Arrival& frame, Output& out) {
  if ((frame.id & (can::kExtended | can::kRemote | can::kError)) != 0 || frame.id >> 5 != node_)
    return false;
  const auto bytes = frame.bytes;
  switch (static_cast<OdriveCommand>(frame.id & 0x1F)) {
    case OdriveCommand::kHeartbeat:
      if (bytes.size() >= 5) on_heartbeat(bytes, frame.last);
      if (axis_state_ != kClosedLoop && !failure() && close_.take_due(frame.last))
        close_loop(frame.last, out);
      break;
    case OdriveCommand::kEncoder:
      if (bytes.size() < 8 || !(std::abs(real(bytes, 0)) <= kTurnsMax) ||
          !(std::abs(real(bytes, 4)) <= kTurnsEachSecondMax))
        break;
      state_.position = static_cast<double>(real(bytes, 0)) * kOdriveTurn;
      state_.velocity = static_cast<double>(real(bytes, 4)) * kOdriveTurn;
      state_.measured = frame.last;
      break;
    case OdriveCommand::kBusVoltage:
      if (bytes.size() >= 4 && std::abs(real(bytes, 0)) <= kVoltsMax)
        state_.volts = static_cast<double>(real(bytes, 0));
      break;
    default:
      break;
  }
  return true;
}

void Odrive::on_heartbeat(std::span<const std::byte> bytes, Time when) {
  last_heartbeat_ = when;
  const auto errors = little_endian<std::uint32_t>(bytes);
  const auto before = std::exchange(axis_state_, std::to_integer<std::uint8_t>(bytes[4]));
  if (errors != 0 && close_.attempts() > 0) {
    const std::array wire = {bytes[3], bytes[2], bytes[1], bytes[0]};
    fail("reports error " + tims::base::to_hex(wire));
  } else if (before == kClosedLoop && axis_state_ != kClosedLoop) {
    fail("has left its closed loop, to state " + std::to_string(axis_state_));
  }
}

void Odrive::on_timeout(Time now, Output& out) {
  if (next_ > now) return;
  next_ = now + kOdriveTick;
  if (last_heartbeat_ != tims::kNever && now - last_heartbeat_ > kSilenceMax)
    fail("has stopped sending heartbeats");
  if (state_.measured == tims::kNever || now - state_.measured > kEncoderLate)
    ask(OdriveCommand::kEncoder, out);
  if (now >= next_volts_) {
    next_volts_ = now + 1s;
    ask(OdriveCommand::kBusVoltage, out);
  }
}

void Odrive::command(double target, Time now, Output& out) {
  const Time deadline = now + kCommandHolds;
  if (task_ == MotorTask::kTurns)
    send(OdriveCommand::kInputVelocity, packed(raw(target / kOdriveTurn), raw(0)), out, deadline);
  else
    send(OdriveCommand::kInputPosition, packed(raw(target / kOdriveTurn), std::uint32_t{0}), out,
         deadline);
}

void Odrive::stand(Output& out) const {
  if (task_ == MotorTask::kTurns) send(OdriveCommand::kInputVelocity, packed(raw(0), raw(0)), out);
  send(OdriveCommand::kAxisState, packed(std::uint32_t{kIdle}), out);
}

void Odrive::stop(Output& out) {
  stand(out);
  next_ = tims::kNever;
}

}  // namespace rack::device
