#include "components/devices/chassis/cia402.h"

#include <cmath>
#include <cstdio>
#include <numbers>

#include "rack/devices/stream_buffer.h"

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr Duration kCia402Tick = 50ms;
constexpr Duration kCia402AnswerTime = 200ms;
constexpr int kCia402Attempts = 3;
constexpr Duration kCia402ReadyTime = 5s;     // from the first message until the motor is enabled
constexpr std::uint16_t kOwnHeartbeat = 100;  // ms
constexpr double kCia402Turn = 2 * std::numbers::pi;

constexpr int kNmtStart = 0x01;
constexpr int kNmtPreOperational = 0x80;
constexpr std::uint8_t kEachSync = 1;
constexpr std::uint8_t kAtOnce = 255;
constexpr std::uint32_t kUnused = 0x80000000;  // flag in the identifier of a process data object

constexpr unsigned kShutDown = 0x06;
constexpr unsigned kSwitchOn = 0x07;
constexpr unsigned kEnable = 0x0F;
constexpr unsigned kQuickStop = 0x02;
constexpr unsigned kDisable = 0x00;
constexpr unsigned kClearFault = 0x80;
constexpr unsigned kNewPosition = 0x10;  // also: start homing
constexpr unsigned kAtOnceBit = 0x20;    // a new position replaces the current one at once

constexpr unsigned kReachedBit = 0x0400;
constexpr unsigned kTakenBit = 0x1000;  // new position acknowledged, or homing attained

std::uint32_t bits(double value) {
  return static_cast<std::uint32_t>(std::lround(std::clamp(value, 0.0, 2e9)));
}

std::string hex(std::uint32_t value, int digits) {
  std::string text;
  for (int shift = 4 * (digits - 1); shift >= 0; shift -= 4)
    text += "0123456789ABCDEF"[value >> shift & 0xF];
  return text;
}

}  // namespace

namespace canopen {

std::array<std::byte, 8> sdo_write(std::uint16_t index, std::uint8_t sub, std::uint32_t value,
                                   std::size_t size) {
  constexpr unsigned kExpedited = 0x23;
  std::array<std::byte, 8> bytes{static_cast<std::byte>(kExpedited | (4 - size) << 2),
                                 static_cast<std::byte>(index), static_cast<std::byte>(index >> 8),
                                 static_cast<std::byte>(sub)};
  for (std::size_t i = 0; i < size; ++i) bytes[4 + i] = static_cast<std::byte>(value >> 8 * i);
  return bytes;
}

void Host::start(Time now) { next_heartbeat_ = next_sync_ = now; }

void Host::on_timeout(Time now, Output& out) {
  if (next_heartbeat_ <= now) {
    next_heartbeat_ = now + kHostHeartbeat;
    out.send(std::array{kOperational}, kHeartbeat + kHost);
  }
  if (next_sync_ <= now) {
    next_sync_ = std::max(next_sync_ + sync_, now);
    out.send({}, kSync);
  }
}

}  // namespace canopen

Cia402State cia402_state(std::uint16_t statusword) {
  switch (statusword & 0x4F) {
    case 0x00:
      return Cia402State::kNotReady;
    case 0x40:
      return Cia402State::kSwitchOnDisabled;
    case 0x0F:
      return Cia402State::kFaultReaction;
    case 0x08:
      return Cia402State::kFault;
    default:
      break;
  }
  switch (statusword & 0x6F) {
    case 0x21:
      return Cia402State::kReadyToSwitchOn;
    case 0x23:
      return Cia402State::kSwitchedOn;
    case 0x27:
      return Cia402State::kOperationEnabled;
    case 0x07:
      return Cia402State::kQuickStopActive;
    default:
      return Cia402State::kNotReady;
  }
}

Cia402::Cia402(const Cia402Settings& settings) : settings_(settings) { plan(); }

// Lists the objects to write before the motor may be enabled.
void Cia402::plan() {
  const bool turns = settings_.task == MotorTask::kTurns;
  const double velocity = settings_.velocity_of_turn / kCia402Turn;
  const auto mode = turns ? Cia402Mode::kProfileVelocity : Cia402Mode::kProfilePosition;
  const auto lost = static_cast<std::uint32_t>(canopen::kHostLost / 1ms);
  constexpr std::uint32_t kQuickStopOption = 3;  // quick stop when the host is lost
  constexpr std::uint32_t kQuickStopRamp = 2;    // brake by the quick stop ramp, then switch off
  setup_ = {
      {0x1016, 1, 4, std::uint32_t{canopen::kHost} << 16 | lost},
      {0x1017, 0, 2, kOwnHeartbeat},
      {0x6007, 0, 2, kQuickStopOption, true},
      {0x605A, 0, 2, kQuickStopRamp, true},
      {0x6060, 0, 1, static_cast<std::uint32_t>(mode)},
      {0x6083, 0, 4, bits(settings_.acceleration * velocity), true},
      {0x6084, 0, 4, bits(settings_.deceleration * velocity), true},
      {0x6085, 0, 4, bits(settings_.quick_stop * velocity), true},
  };
  map(0x1400, canopen::kRpdo1, kAtOnce, {0x60400010, turns ? 0x60FF0020U : 0x607A0020U});
  if (!turns) map(0x1401, canopen::kRpdo2, kAtOnce, {0x60810020, 0x60830020});
  map(0x1800, canopen::kTpdo1, kEachSync, {0x60410010, 0x60640020});
  map(0x1801, canopen::kTpdo2, kEachSync, {0x606C0020});
}

// A process data object must be disabled while its mapping changes.
void Cia402::map(std::uint16_t communication, std::uint32_t id, std::uint8_t transmission,
                 std::initializer_list<std::uint32_t> objects) {
  constexpr std::uint16_t kMappingBehind = 0x200;
  const auto mapping = static_cast<std::uint16_t>(communication + kMappingBehind);
  setup_.push_back({communication, 1, 4, kUnused | (id + settings_.node)});
  setup_.push_back({communication, 2, 1, transmission});
  setup_.push_back({mapping, 0, 1, 0});
  std::uint8_t sub = 0;
  for (const std::uint32_t object : objects) setup_.push_back({mapping, ++sub, 4, object});
  setup_.push_back({mapping, 0, 1, sub});
  setup_.push_back({communication, 1, 4, id + settings_.node});
}

void Cia402::start(Time now, Output& out) {
  clear();
  step_ = 0;
  is_set_up_ = settings_.only_listen;
  was_enabled_ = pulse_ = is_new_target_ = false;
  statusword_ = 0;
  error_ = 0;
  position_.reset();
  homing_ = Homing::kNone;
  last_heartbeat_ = tims::kNever;
  next_ = now + kCia402Tick;
  ready_due_ = tims::kNever;
  writing_.reset();
  nmt(kNmtPreOperational, out);
  write(setup_[step_], now, out);
}

void Cia402::nmt(int command, Output& out) const {
  out.send(std::array{static_cast<std::byte>(command), static_cast<std::byte>(settings_.node)},
           canopen::kNmt);
}

void Cia402::write(const Object& object, Time now, Output& out) {
  if (!writing_) answer_.reset();
  writing_ = object;
  answer_.sent(now, kCia402AnswerTime);
  out.send(canopen::sdo_write(object.index, object.sub, object.value, object.size),
           canopen::kSdoRequest + settings_.node);
}

bool Cia402::on_frame(const Arrival& frame, Output& out) {
  const std::uint32_t id = frame.id;
  const auto bytes = frame.bytes;
  if (is_mine(id, canopen::kTpdo1)) {
    if (bytes.size() >= 6) on_status(bytes, frame.last, out);
  } else if (is_mine(id, canopen::kTpdo2)) {
    if (bytes.size() >= 4)
      state_.velocity =
          little_endian<std::int32_t>(bytes) / settings_.velocity_of_turn * kCia402Turn;
  } else if (is_mine(id, canopen::kSdoAnswer)) {
    if (bytes.size() == 8) on_sdo(bytes, frame.last, out);
  } else if (is_mine(id, canopen::kHeartbeat)) {
    if (!bytes.empty()) on_heartbeat(bytes, frame.last, out);
  } else if (is_mine(id, canopen::kEmergency)) {
    if (bytes.size() >= 2) error_ = little_endian<std::uint16_t>(bytes);
    if (error_ != 0 && was_enabled_) fail("reports error " + hex(error_, 4));
  } else {
    return false;
  }
  return true;
}

void Cia402::on_sdo(std::span<const std::byte> bytes, Time now, Output& out) {
  constexpr std::byte kDone{0x60};
  constexpr std::byte kAborted{0x80};
  if (!writing_ || little_endian<std::uint16_t>(bytes, 1) != writing_->index ||
      std::to_integer<int>(bytes[3]) != writing_->sub)
    return;
  if (bytes[0] == kAborted && !writing_->is_optional) {
    fail("refuses object " + hex(writing_->index, 4) + ":" + std::to_string(writing_->sub) +
         ", abort code " + hex(little_endian<std::uint32_t>(bytes, 4), 8));
    writing_.reset();
  } else if (bytes[0] == kDone || bytes[0] == kAborted) {
    writing_.reset();
    on_written(now, out);
  }
}

void Cia402::on_written(Time now, Output& out) {
  if (!is_set_up_) {
    if (++step_ < setup_.size()) {
      write(setup_[step_], now, out);
      return;
    }
    is_set_up_ = true;
    ready_due_ = now + kCia402ReadyTime;
    nmt(kNmtStart, out);
  } else if (homing_ == Homing::kMethod) {
    homing_ = Homing::kMode;
    write({0x6060, 0, 1, static_cast<std::uint32_t>(Cia402Mode::kHoming)}, now, out);
  } else if (homing_ == Homing::kMode) {
    homing_ = Homing::kRuns;
    send_control(kEnable | kNewPosition, target_, out);
  } else if (homing_ == Homing::kBack) {
    homing_ = Homing::kNone;
  }
}

void Cia402::on_heartbeat(std::span<const std::byte> bytes, Time when, Output& out) {
  constexpr std::byte kBootUp{0x00};
  last_heartbeat_ = when;
  const std::byte state = bytes[0] & std::byte{0x7F};
  if (state == kBootUp && was_enabled_)
    fail("was restarted");
  else if (state == kBootUp)
    start(when, out);
  else if (was_enabled_ && state != canopen::kOperational)
    fail("is no longer operational");
}

void Cia402::on_status(std::span<const std::byte> bytes, Time when, Output& out) {
  if (!is_set_up_) return;
  statusword_ = little_endian<std::uint16_t>(bytes);
  const auto position = little_endian<std::int32_t>(bytes, 2);
  // Starts at the current position and adds differences, because the 32 bit counter may overflow.
  const auto steps = position_ ? static_cast<std::int32_t>(static_cast<std::uint32_t>(position) -
                                                           static_cast<std::uint32_t>(*position_))
                               : position;
  state_.position += steps / settings_.increments_of_turn * kCia402Turn;
  position_ = position;
  state_.measured = when;
  const auto drive = drive_state();
  if (drive == Cia402State::kOperationEnabled) {
    was_enabled_ = true;
    if (homing_ == Homing::kRuns && (statusword_ & kTakenBit) != 0) {
      homing_ = Homing::kBack;
      position_.reset();
      state_.position = 0;
      write({0x6060, 0, 1, static_cast<std::uint32_t>(Cia402Mode::kProfilePosition)}, when, out);
    }
  } else if (was_enabled_) {
    fail(drive == Cia402State::kFault || drive == Cia402State::kFaultReaction
             ? "has a fault" + (error_ != 0 ? ", error " + hex(error_, 4) : std::string())
             : "is no longer enabled, statusword " + hex(statusword_, 4));
  } else {
    climb(out);
  }
}

// Requests the next state towards operation enabled.
void Cia402::climb(Output& out) {
  pulse_ = !pulse_;
  switch (drive_state()) {
    case Cia402State::kFault:
      return send_control(pulse_ ? kClearFault : kDisable, 0, out);
    case Cia402State::kQuickStopActive:
      return send_control(kDisable, 0, out);
    case Cia402State::kSwitchOnDisabled:
      return send_control(kShutDown, 0, out);
    case Cia402State::kReadyToSwitchOn:
      return send_control(kSwitchOn, 0, out);
    case Cia402State::kSwitchedOn:
      // A positioning drive keeps its current position.
      target_ = settings_.task == MotorTask::kPositions ? position_.value_or(0) : 0;
      pulse_ = false;
      return send_control(kEnable, target_, out);
    default:
      return;
  }
}

void Cia402::on_timeout(Time now, Output& out) {
  if (next_ > now) return;
  next_ = now + kCia402Tick;
  if (writing_ && answer_.take_due(now)) {
    if (answer_.may_repeat(kCia402Attempts))
      write(Object(*writing_), now, out);
    else
      fail("does not answer to SDO; check its power, cable and bit rate");
  }
  if (last_heartbeat_ != tims::kNever && now - last_heartbeat_ > kSilenceMax)
    fail("has stopped sending heartbeats");
  if (was_enabled_ && now - state_.measured > kSilenceMax) fail("has stopped answering SYNC");
  if (!was_enabled_ && now >= ready_due_)
    fail("does not enable its motor, statusword " + hex(statusword_, 4) +
         (error_ != 0 ? ", error " + hex(error_, 4) : ""));
}

void Cia402::send_control(unsigned controlword, std::int32_t target, Output& out,
                          Time deadline) const {
  std::array<std::byte, 6> bytes{static_cast<std::byte>(controlword),
                                 static_cast<std::byte>(controlword >> 8)};
  for (std::size_t i = 0; i < 4; ++i)
    bytes[2 + i] = static_cast<std::byte>(static_cast<std::uint32_t>(target) >> 8 * i);
  out.send_before(deadline, bytes, canopen::kRpdo1 + settings_.node);
}

void Cia402::command(double target, Time now, Output& out) {
  if (!is_ready() || is_homing()) return;
  const bool turns = settings_.task == MotorTask::kTurns;
  const double unit = turns ? settings_.velocity_of_turn : settings_.increments_of_turn;
  const auto wanted =
      static_cast<std::int32_t>(std::lround(std::clamp(target / kCia402Turn * unit, -2e9, 2e9)));
  if (turns) {
    send_control(kEnable, wanted, out, now + kCommandHolds);
    return;
  }
  // Each new position needs a pulse of its bit, which the drive must acknowledge.
  if (wanted != target_) {
    target_ = wanted;
    is_new_target_ = true;
    pulse_ = false;
  }
  const bool is_taken = (statusword_ & kTakenBit) != 0;
  if (is_new_target_ && is_taken && pulse_) is_new_target_ = false;
  pulse_ = is_new_target_ && (pulse_ || !is_taken);
  send_control(kEnable | kAtOnceBit | (pulse_ ? kNewPosition : 0), target_, out,
               now + kCommandHolds);
}

bool Cia402::is_reached() const {
  return is_ready() && !is_new_target_ && !is_homing() && (statusword_ & kReachedBit) != 0;
}

void Cia402::limit(double velocity, double acceleration, Output& out) const {
  const double unit = settings_.velocity_of_turn / kCia402Turn;
  const std::array values{bits(std::abs(velocity) * unit),
                          bits((acceleration > 0 ? acceleration : settings_.acceleration) * unit)};
  if (velocity == 0) return;
  std::array<std::byte, 8> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<std::byte>(values[i / 4] >> 8 * (i % 4));
  out.send(bytes, canopen::kRpdo2 + settings_.node);
}

void Cia402::home(Time now, Output& out) {
  if (!is_ready()) return;
  homing_ = Homing::kMethod;
  is_new_target_ = false;
  target_ = 0;
  write({0x6098, 0, 1, static_cast<std::uint8_t>(settings_.homing_method)}, now, out);
}

// A drive that is not enabled ignores this.
void Cia402::stand(Output& out) const {
  send_control(kQuickStop, settings_.task == MotorTask::kTurns ? 0 : target_, out);
}

void Cia402::stop(Output& out) {
  stand(out);
  next_ = tims::kNever;
}

}  // namespace rack::device
