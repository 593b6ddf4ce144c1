#include "components/devices/chassis/motor_bus.h"

#include <algorithm>
#include <bit>
#include <numbers>

#include "rack/devices/stream_buffer.h"

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr double kMotorBusTurn = 2 * std::numbers::pi;
constexpr Acceleration<double> kShaftAcceleration{400, 400};  // rad/s2
constexpr Duration kNodeTick = 10ms;
constexpr Duration kOdriveWatchdog = 200ms;
constexpr Duration kVescTick = 20ms;
constexpr Duration kVescTimeout = 1s;
constexpr Duration kCanopenTick = 10ms;

template <typename Number>
void put_big(std::vector<std::byte>& bytes, Number number) {
  for (std::size_t i = sizeof number; i-- > 0;)
    bytes.push_back(static_cast<std::byte>(static_cast<std::uint64_t>(number) >> 8 * i));
}
void put_real(std::vector<std::byte>& bytes, double value) {
  append_little(bytes, std::bit_cast<std::uint32_t>(static_cast<float>(value)));
}
double real(std::span<const std::byte> bytes) {
  return static_cast<double>(std::bit_cast<float>(little_endian<std::uint32_t>(bytes)));
}
struct Nobody final : Output {
  void send(std::span<const std::byte>, std::uint32_t) override {}
};
std::int32_t whole(double value) { return static_cast<std::int32_t>(std::llround(value)); }

}  // namespace

void ShaftModel::step(Time now) {
  target_.step(now, [&](double seconds) {
    const Target& target = target_.in_effect();
    if (target.position)
      motion_.go_to(*target.position, target.limit, seconds);
    else
      motion_.run(target.velocity, kShaftAcceleration, seconds);
  });
}

bool ShaftModel::is_there() const {
  constexpr double kNear = 1e-3;
  const auto& target = target_.in_effect().position;
  return !target || std::abs(*target - position()) < kNear;
}

// --- the bus

void MotorBus::start(Time now, Output&) {
  for (const auto& motor : motors_) motor->start(now);
}

void MotorBus::on_arrival(const Arrival& arrival, Output& out) {
  Nobody nobody;
  for (std::size_t i = 0; i < motors_.size(); ++i)
    motors_[i]->on_frame(arrival, silent_ == i ? static_cast<Output&>(nobody) : out);
}

void MotorBus::on_timeout(Time now, Output& out) {
  Nobody nobody;
  for (std::size_t i = 0; i < motors_.size(); ++i)
    if (motors_[i]->next_timeout() <= now)
      motors_[i]->on_timeout(now, silent_ == i ? static_cast<Output&>(nobody) : out);
}

Time MotorBus::next_timeout() const {
  Time next = tims::kNever;
  for (const auto& motor : motors_) next = std::min(next, motor->next_timeout());
  return next;
}

void MotorBus::turned(Time now, std::span<double> positions) {
  for (std::size_t i = 0; i < motors_.size(); ++i) {
    motors_[i]->step(now);
    positions[i] = motors_[i]->shaft().position();
  }
}

bool MotorBus::stands() const {
  return std::ranges::all_of(
      motors_, [](const auto& motor) { return std::abs(motor->shaft().velocity()) < 1e-6; });
}

namespace {

template <class Make>
std::unique_ptr<Dialogue> bus_of(std::uint8_t motors, Make make) {
  auto bus = std::make_unique<MotorBus>();
  for (std::uint8_t node = 1; node <= motors; ++node) bus->add(make(node));
  return bus;
}

std::unique_ptr<EmulatedMotor> default_drive(std::uint8_t node) {
  constexpr double kIncrements = 4096;  // default of the drivers' parameter
  return std::make_unique<Cia402Emulator>(node, kIncrements, kIncrements);
}

}  // namespace

std::unique_ptr<Dialogue> odrive_base() {
  return bus_of(2, [](std::uint8_t node) { return std::make_unique<OdriveEmulator>(node); });
}
std::unique_ptr<Dialogue> vesc_base() {
  return bus_of(2, [](std::uint8_t node) { return std::make_unique<VescEmulator>(node, 7); });
}
std::unique_ptr<Dialogue> cia402_base() { return bus_of(2, default_drive); }
std::unique_ptr<Dialogue> robucar() { return bus_of(6, default_drive); }
std::unique_ptr<Dialogue> servo() { return bus_of(1, default_drive); }

// --- ODrive

void OdriveEmulator::start(Time now) {
  next_ = now + kNodeTick;
  fed_ = now;
}

void OdriveEmulator::on_frame(const Arrival& frame, Output& out) {
  if ((frame.id & can::kExtended) != 0 || (frame.id & 0x7FF) >> 5 != node_) return;
  const auto command = static_cast<OdriveCommand>(frame.id & 0x1F);
  shaft_.step(frame.last);
  if ((frame.id & can::kRemote) != 0) {
    if (command == OdriveCommand::kEncoder) send_encoder(out);
    if (command == OdriveCommand::kBusVoltage) {
      std::vector<std::byte> bytes;
      put_real(bytes, 24.5);
      put_real(bytes, 1.5);
      out.send(bytes, odrive_id(node_, command));
    }
    return;
  }
  if (frame.bytes.size() >= 4 && command == OdriveCommand::kAxisState) {
    enabled_ = frame.bytes[0] == std::byte{8} && errors == 0;
    fed_ = frame.last;
    shaft_.turn(0);
  }
  if (frame.bytes.size() >= 4 && command == OdriveCommand::kControllerMode)
    positions_ = frame.bytes[0] == std::byte{3};
  if (command == OdriveCommand::kClearErrors) errors = 0;
  if (!enabled_ || frame.bytes.size() < 8) return;
  if (command == OdriveCommand::kInputVelocity && !positions_)
    shaft_.turn(real(frame.bytes) * kMotorBusTurn);
  if (command == OdriveCommand::kInputPosition && positions_)
    shaft_.go_to(real(frame.bytes) * kMotorBusTurn, 20);
  if (command == OdriveCommand::kInputVelocity || command == OdriveCommand::kInputPosition)
    fed_ = frame.last;
}

void OdriveEmulator::send_encoder(Output& out) const {
  std::vector<std::byte> bytes;
  put_real(bytes, shaft_.position() / kMotorBusTurn);
  put_real(bytes, shaft_.velocity() / kMotorBusTurn);
  out.send(bytes, odrive_id(node_, OdriveCommand::kEncoder));
}

void OdriveEmulator::on_timeout(Time now, Output& out) {
  next_ = now + kNodeTick;
  shaft_.step(now);
  if (enabled_ && has_watchdog && now - fed_ > kOdriveWatchdog) {
    errors = 0x01000000;  // watchdog timer expired
    enabled_ = false;
  }
  if (errors != 0) enabled_ = false;
  if (!enabled_) shaft_.turn(0);
  if (sends_encoder) send_encoder(out);
  if (tick_++ % 10 != 0) return;
  std::vector<std::byte> bytes;
  append_little(bytes, errors);
  append_little(bytes, std::uint32_t{enabled_ ? 8U : 1U});
  out.send(bytes, odrive_id(node_, OdriveCommand::kHeartbeat));
}

// --- VESC

void VescEmulator::start(Time now) {
  next_ = now + kVescTick;
  fed_ = now;
  enabled_ = true;
}

void VescEmulator::on_frame(const Arrival& frame, Output&) {
  shaft_.step(frame.last);
  if (frame.bytes.size() < 4) return;
  const auto value = big_endian<std::int32_t>(frame.bytes);
  if (frame.id == vesc_id(node_, VescPacket::kSetRpm))
    shaft_.turn(value * kMotorBusTurn / 60 / pole_pairs_);
  else if (frame.id == vesc_id(node_, VescPacket::kSetCurrent))
    shaft_.turn(0);
  else if (frame.id == vesc_id(node_, VescPacket::kSetPosition))
    shaft_.go_to(std::remainder(value / 1e6 / 360 * kMotorBusTurn, kMotorBusTurn), 20);
  else
    return;
  fed_ = frame.last;
}

void VescEmulator::on_timeout(Time now, Output& out) {
  next_ = now + kVescTick;
  shaft_.step(now);
  if (now - fed_ > kVescTimeout) shaft_.turn(0);
  std::vector<std::byte> bytes;
  put_big(bytes, whole(shaft_.velocity() / kMotorBusTurn * 60 * pole_pairs_));
  put_big(bytes, std::int16_t{12});
  put_big(bytes, std::int16_t{100});
  out.send(bytes, vesc_id(node_, VescPacket::kStatus1));
  bytes.clear();
  put_big(bytes, std::int32_t{0});
  put_big(bytes, std::int16_t{0});
  double degrees = std::fmod(shaft_.position() / kMotorBusTurn * 360, 360);
  put_big(bytes, static_cast<std::int16_t>(whole(degrees * 50)));
  out.send(bytes, vesc_id(node_, VescPacket::kStatus4));
  if (!sends_tachometer) return;
  bytes.clear();
  put_big(bytes, whole(std::floor(shaft_.position() / kMotorBusTurn * 6 * pole_pairs_)));
  put_big(bytes, std::int16_t{365});
  put_big(bytes, std::int16_t{0});
  out.send(bytes, vesc_id(node_, VescPacket::kStatus5));
}

// --- CiA 402

void Cia402Emulator::start(Time now) { next_ = now + kCanopenTick; }

std::optional<std::uint32_t> Cia402Emulator::object(std::uint16_t index, std::uint8_t sub) const {
  const auto found = objects_.find(std::uint32_t{index} << 8 | sub);
  if (found == objects_.end()) return {};
  return found->second;
}

void Cia402Emulator::on_frame(const Arrival& frame, Output& out) {
  const auto bytes = frame.bytes;
  shaft_.step(frame.last);
  if (frame.id == canopen::kNmt && bytes.size() == 2) {
    const auto node = std::to_integer<std::uint8_t>(bytes[1]);
    if (node == 0 || node == node_) operational_ = bytes[0] == std::byte{1};
  } else if (frame.id == canopen::kHeartbeat + canopen::kHost) {
    last_host_heartbeat_ = frame.last;
  } else if (frame.id == canopen::kSdoRequest + node_ && bytes.size() == 8) {
    on_sdo(bytes, out);
  } else if (frame.id == canopen::kRpdo1 + node_ && bytes.size() == 6 && operational_) {
    on_control(little_endian<std::uint16_t>(bytes), little_endian<std::int32_t>(bytes, 2));
  } else if (frame.id == canopen::kRpdo2 + node_ && bytes.size() == 8 && operational_) {
    objects_[0x608100] = little_endian<std::uint32_t>(bytes);
  } else if (frame.id == canopen::kSync && operational_) {
    send_process_data(out);
  }
}

void Cia402Emulator::on_sdo(std::span<const std::byte> bytes, Output& out) {
  const auto index = little_endian<std::uint16_t>(bytes, 1);
  std::vector<std::byte> answer(bytes.begin(), bytes.end());
  if (lacks == index) {
    answer[0] = std::byte{0x80};
    answer.resize(4);
    append_little(answer, std::uint32_t{0x06020000});
  } else {
    answer[0] = std::byte{0x60};
    std::fill(answer.begin() + 4, answer.end(), std::byte{0});
    objects_[std::uint32_t{index} << 8 | std::to_integer<std::uint32_t>(bytes[3])] =
        little_endian<std::uint32_t>(bytes, 4);
  }
  out.send(answer, canopen::kSdoAnswer + node_);
}

void Cia402Emulator::on_control(unsigned controlword, std::int32_t target) {
  const bool rises_clear = (controlword & 0x80) != 0 && (control_ & 0x80) == 0;
  const bool rises_new = (controlword & 0x10) != 0 && (control_ & 0x10) == 0;
  control_ = controlword;
  if (state_ == Cia402State::kFault) {
    if (rises_clear) state_ = Cia402State::kSwitchOnDisabled;
    return;
  }
  if ((controlword & 0x02) == 0) {
    state_ = Cia402State::kSwitchOnDisabled;
  } else if ((controlword & 0x04) == 0) {
    quick_stop();
  } else if (state_ == Cia402State::kSwitchOnDisabled) {
    if ((controlword & 0x07) == 0x06) state_ = Cia402State::kReadyToSwitchOn;
  } else if (state_ == Cia402State::kReadyToSwitchOn) {
    if ((controlword & 0x0F) == 0x07) state_ = Cia402State::kSwitchedOn;
  } else if (state_ == Cia402State::kSwitchedOn) {
    if ((controlword & 0x0F) == 0x0F) state_ = Cia402State::kOperationEnabled;
  }
  enabled_ = state_ == Cia402State::kOperationEnabled;
  if (!enabled_) {
    shaft_.turn(0);
    return;
  }
  const auto mode = object(0x6060, 0).value_or(0) & 0xFF;
  if (mode == 3) shaft_.turn(target / velocity_ * kMotorBusTurn);
  if ((controlword & 0x10) == 0) taken_ = false;
  if (mode == 1 && rises_new) {
    taken_ = true;
    const double limit = object(0x6081, 0).value_or(0) / velocity_ * kMotorBusTurn;
    shaft_.go_to(target / increments_ * kMotorBusTurn, limit > 0 ? limit : 20);
  }
  if (mode == 6 && rises_new) {
    homed_ = true;
    shaft_.set_position(0);
    shaft_.turn(0);
  }
}

void Cia402Emulator::quick_stop() {
  if (state_ == Cia402State::kOperationEnabled) state_ = Cia402State::kQuickStopActive;
  enabled_ = false;
  shaft_.turn(0);
}

unsigned Cia402Emulator::statusword() const {
  constexpr std::array<unsigned, 8> kStatusBits = {0x00, 0x40, 0x21, 0x23, 0x27, 0x07, 0x0F, 0x08};
  const auto mode = object(0x6060, 0).value_or(0) & 0xFF;
  unsigned status = 0x1210 & 0x0210;  // voltage, remote
  status |= kStatusBits[static_cast<std::size_t>(state_)];
  if (shaft_.is_there()) status |= 0x0400;
  if ((mode == 1 && taken_) || (mode == 6 && homed_)) status |= 0x1000;
  return status;
}

void Cia402Emulator::send_process_data(Output& out) const {
  std::vector<std::byte> bytes;
  append_little(bytes, static_cast<std::uint16_t>(statusword()));
  append_little(bytes, whole(shaft_.position() / kMotorBusTurn * increments_));
  out.send(bytes, canopen::kTpdo1 + node_);
  bytes.clear();
  append_little(bytes, whole(shaft_.velocity() / kMotorBusTurn * velocity_));
  out.send(bytes, canopen::kTpdo2 + node_);
}

void Cia402Emulator::on_timeout(Time now, Output& out) {
  next_ = now + kCanopenTick;
  shaft_.step(now);
  const auto consumer = object(0x1016, 1).value_or(0);
  const Duration patience = std::chrono::milliseconds(consumer & 0xFFFF);
  if (consumer != 0 && operational_ && last_host_heartbeat_ != tims::kNever &&
      now - last_host_heartbeat_ > patience && state_ == Cia402State::kOperationEnabled)
    quick_stop();
  const auto period = object(0x1017, 0).value_or(0) & 0xFFFF;
  if (period == 0 || ++tick_ % std::max(1, static_cast<int>(period / 10)) != 0) return;
  out.send(std::array{operational_ ? std::byte{0x05} : std::byte{0x7F}},
           canopen::kHeartbeat + node_);
}

void Cia402Emulator::set_fault(std::uint16_t error, Output& out) {
  state_ = Cia402State::kFault;
  enabled_ = false;
  shaft_.turn(0);
  std::vector<std::byte> bytes;
  append_little(bytes, error);
  bytes.resize(8);
  out.send(bytes, canopen::kEmergency + node_);
}

void Cia402Emulator::restart(Output& out) {
  objects_.clear();
  operational_ = enabled_ = false;
  state_ = Cia402State::kSwitchOnDisabled;
  shaft_.turn(0);
  out.send(std::array{std::byte{0}}, canopen::kHeartbeat + node_);
}

}  // namespace rack::device
