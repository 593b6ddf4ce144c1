#include "components/devices/chassis/er1.h"

#include <algorithm>
#include <cmath>

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kEr1Baud = 250000;
constexpr Duration kEr1Period = 100ms;
constexpr Duration kEr1AnswerTime = 30ms;
constexpr int kEr1Attempts = 6;  // tolerates delays of a busy host
constexpr std::int32_t kPower = 0x4CC0;
constexpr std::int32_t kAcceleration = 0xB0;
constexpr std::int32_t kVelocityProfile = 1;
constexpr double kVelocityUnit = 256;  // see above

bool adds_up_to_nothing(std::span<const std::byte> bytes) {
  unsigned sum = 0;
  for (const std::byte byte : bytes) sum += std::to_integer<unsigned>(byte);
  return (sum & 0xFF) == 0;
}

std::byte checksum(std::span<const std::byte> bytes) {
  unsigned sum = 0;
  for (const std::byte byte : bytes) sum += std::to_integer<unsigned>(byte);
  return static_cast<std::byte>(0x100 - (sum & 0xFF));
}

using Code = Er1Code;
struct SetUp {
  Code code;
  std::int32_t value;
};
constexpr std::array<SetUp, 7> kSetUp = {{{Code::kReset, 0},
                                          {Code::kSetLimitSwitchMode, 0},
                                          {Code::kSetMotorCommand, 0},
                                          {Code::kSetProfileMode, kVelocityProfile},
                                          {Code::kSetAcceleration, kAcceleration},
                                          {Code::kSetDeceleration, kAcceleration},
                                          {Code::kUpdate, 0}}};
// The commands of each round, sent to both wheels.
constexpr std::array<Code, 4> kRound = {Code::kSetMotorCommand, Code::kSetVelocity, Code::kUpdate,
                                        Code::kGetActualPosition};

}  // namespace

std::size_t er1_value_size(Er1Code code) {
  switch (code) {
    case Code::kSetMotorCommand:
    case Code::kSetLimitSwitchMode:
    case Code::kSetProfileMode:
      return 2;
    case Code::kSetVelocity:
    case Code::kSetAcceleration:
    case Code::kSetDeceleration:
      return 4;
    default:
      return 0;
  }
}

std::size_t er1_answer_size(Er1Code code) { return code == Code::kGetActualPosition ? 4 : 0; }

Er1Command::Bytes Er1Command::encode() const {
  Bytes out;
  out.bytes[0] = static_cast<std::byte>(address);
  out.bytes[3] = static_cast<std::byte>(code);
  const std::size_t size = er1_value_size(code);
  for (std::size_t i = 0; i < size; ++i)
    out.bytes[4 + i] =
        static_cast<std::byte>(static_cast<std::uint32_t>(value) >> 8 * (size - 1 - i));
  out.size = 4 + size;
  out.bytes[1] = checksum(out.view());
  return out;
}

std::optional<Er1Command> Er1Command::decode(std::span<const std::byte> bytes) {
  constexpr std::size_t kHead = 4;
  if (bytes.size() < kHead || bytes[0] > std::byte{1} || bytes[2] != std::byte{0} ||
      !adds_up_to_nothing(bytes))
    return std::nullopt;
  Er1Command command{.address = std::to_integer<std::uint8_t>(bytes[0]),
                     .code = static_cast<Er1Code>(bytes[3])};
  const std::size_t size = er1_value_size(command.code);
  if (bytes.size() != kHead + size) return std::nullopt;
  if (size == 2) command.value = big_endian<std::int16_t>(bytes, kHead);
  if (size == 4) command.value = big_endian<std::int32_t>(bytes, kHead);
  return command;
}

std::vector<std::byte> er1_stop() {
  std::vector<std::byte> bytes;
  for (const auto code : {Code::kSetVelocity, Code::kSetMotorCommand, Code::kUpdate}) {
    for (const std::uint8_t address : {std::uint8_t{0}, std::uint8_t{1}}) {
      const auto command = Er1Command{.address = address, .code = code}.encode();
      bytes.insert(bytes.end(), command.view().begin(), command.view().end());
    }
  }
  return bytes;
}

void Er1::start(Time now, Output& out) {
  clear_failure();
  answer_.clear();
  is_set_up_ = settings_.only_listen;
  is_asking_ = has_data_ = is_in_round_ = false;
  index_ = 0;
  timer_.reset();
  wanted_ = sending_ = confirmed_ = distances_ = {};
  counts_ = {};
  confirmed_since_ = now;
  if (settings_.only_listen) return;
  timer_.wait_until(now);
  out.set_baud(kEr1Baud);
}

std::size_t Er1::count() const {
  if (!is_set_up_) return 2 * kSetUp.size();
  return 2 * (kRound.size() - (settings_.ticks_per_mm > 0 ? 0 : 1));
}

Er1Command Er1::command(std::size_t index) const {
  if (!is_set_up_) {
    const SetUp& step = kSetUp[index % kSetUp.size()];
    return {.address = static_cast<std::uint8_t>(index / kSetUp.size()),
            .code = step.code,
            .value = step.value};
  }
  const std::size_t wheel = index % 2;
  Er1Command command{.address = static_cast<std::uint8_t>(wheel), .code = kRound[index / 2]};
  if (command.code == Code::kSetMotorCommand) command.value = kPower;
  if (command.code == Code::kSetVelocity) {
    const double sign = wheel == kLeft ? -1 : 1;
    command.value = static_cast<std::int32_t>(
        std::lround(sign * sending_[wheel] * settings_.velocity_factor * kVelocityUnit));
  }
  return command;
}

void Er1::ask(Time now, Output& out) {
  answer_.clear();
  is_asking_ = true;
  timer_.sent(now, kEr1AnswerTime);
  out.send(command(index_).encode().view());
}

void Er1::on_timeout(Time now, Output& out) {
  if (!timer_.take_due(now)) return;
  if (!is_asking_)
    next_command(now, out);
  else if (timer_.may_repeat(kEr1Attempts))
    ask(now, out);
  else
    fail(tims::Errc::kTimeout,
         "a motion processor of the robot does not answer; check that the control "
         "module is switched on");
}

// Follows the rounds of a recording by its commands. There are no rounds during the setup and after
// the stop commands; a power command marks the beginning of a round.
void Er1::on_sent(const Arrival& arrival) {
  if (!settings_.only_listen) return;
  is_asking_ = false;
  const auto sent = Er1Command::decode(arrival.bytes);
  if (!sent || sent->code == Code::kReset) is_in_round_ = false;
  if (!sent) return;
  if (sent->code == Code::kSetMotorCommand) is_in_round_ = sent->value != 0;
  const auto* const place = std::ranges::find(kRound, sent->code);
  if (!is_in_round_ || place == kRound.end()) return;
  const std::size_t wheel = sent->address;
  if (sent->code == Code::kSetVelocity)
    sending_[wheel] =
        (wheel == kLeft ? -1 : 1) * sent->value / (settings_.velocity_factor * kVelocityUnit);
  answer_.clear();
  index_ = 2 * static_cast<std::size_t>(place - kRound.begin()) + wheel;
  is_asking_ = index_ < count();
}

// A new round begins every 100 ms, or as soon as the requested speed changes.
void Er1::next_command(Time now, Output& out) {
  if (index_ == 0 && is_set_up_) {
    sending_ = wanted_;
    round_ = now;
  }
  timer_.reset();
  ask(now, out);
}

void Er1::drive(const ChassisSpeed& speed, Time now) {
  if (settings_.only_listen) return;
  auto omega = static_cast<double>(speed.omega);
  if (speed.vx == 0 && std::abs(omega) < settings_.omega_min) omega = 0;
  const double turn = omega * settings_.axis_width / 2;
  wanted_[kLeft] = static_cast<double>(speed.vx) + turn;
  wanted_[kRight] = static_cast<double>(speed.vx) - turn;
  if (is_set_up_ && !is_asking_ && index_ == 0 && wanted_ != sending_)
    timer_.wait_until(std::min(timer_.due(), now));
}

void Er1::on_arrival(const Arrival& arrival, Output& out) {
  if (!is_asking_) return;
  answer_.add(arrival);
  const std::size_t size = 2 + er1_answer_size(command(index_).code);
  if (answer_.size() < size) return;
  const auto answer = answer_.bytes().first(size);
  // Invalid answers are ignored: after the timeout the command is repeated.
  if (!adds_up_to_nothing(answer) || answer[0] != std::byte{0}) return;
  is_asking_ = false;
  on_answer(answer.subspan(2), arrival.last);
  if (++index_ < count()) {
    if (!settings_.only_listen) next_command(arrival.last, out);
    return;
  }
  index_ = 0;
  if (is_set_up_) on_round(arrival.last);
  if (settings_.only_listen) return;
  is_set_up_ = true;
  timer_.wait_until(wanted_ != sending_ ? arrival.last : round_ + kEr1Period);
}

void Er1::on_answer(std::span<const std::byte> answer, Time now) {
  if (!is_set_up_) return;
  const Er1Command asked = command(index_);
  const std::size_t wheel = asked.address;
  if (asked.code == Code::kUpdate && wheel == kLeft) {
    const double seconds = std::chrono::duration<double>(now - confirmed_since_).count();
    if (settings_.ticks_per_mm <= 0)
      for (std::size_t i = 0; i < 2; ++i) distances_[i] += really(confirmed_[i]) * seconds;
    confirmed_ = sending_;
    confirmed_since_ = now;
  }
  if (asked.code != Code::kGetActualPosition) return;
  const auto count = big_endian<std::int32_t>(answer);
  if (counts_[wheel]) {
    const auto ticks = static_cast<std::int32_t>(static_cast<std::uint32_t>(count) -
                                                 static_cast<std::uint32_t>(*counts_[wheel]));
    distances_[wheel] += (wheel == kLeft ? -1 : 1) * ticks / settings_.ticks_per_mm;
  }
  counts_[wheel] = count;
}

double Er1::really(double speed) const {
  if (speed == 0) return 0;
  const double size = settings_.odometry_factor * std::abs(speed) - settings_.odometry_offset;
  return std::copysign(std::max(size, 0.0), speed);
}

void Er1::on_round(Time now) {
  constexpr Duration kJitter = 5ms;
  if (recorded_ != Time{} && now - recorded_ < kEr1Period - kJitter) return;
  data_.deltaX = static_cast<f32>((distances_[kLeft] + distances_[kRight]) / 2);
  data_.deltaRho =
      static_cast<f32>((distances_[kLeft] - distances_[kRight]) / settings_.axis_width);
  const double left = really(confirmed_[kLeft]);
  const double right = really(confirmed_[kRight]);
  data_.vx = static_cast<f32>((left + right) / 2);
  data_.omega = static_cast<f32>((left - right) / settings_.axis_width);
  distances_ = {};
  recorded_ = now;
  has_data_ = true;
}

bool Er1::take(ChassisData& data, Time& recorded) {
  if (!std::exchange(has_data_, false)) return false;
  data = data_;
  recorded = recorded_;
  return true;
}

void Er1::stop(Time, Output& out) {
  if (settings_.only_listen) return;
  out.send(er1_stop());
  is_set_up_ = is_asking_ = false;
  timer_.stop();
}

}  // namespace rack::device
