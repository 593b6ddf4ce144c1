#include "components/devices/chassis/p2os.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr std::byte kHead1{0xFA};
constexpr std::byte kHead2{0xFB};
constexpr std::size_t kFrame = 3;
constexpr std::uint32_t kP2osBaud = 9600;
constexpr Duration kP2osBetween = 10ms;  // pause between two commands
constexpr Duration kP2osAnswerTime = 500ms;
constexpr Duration kRepeat = 200ms;  // far below the watchdog time of 2 s
constexpr int kP2osAttempts = 6;
constexpr int kEncoderPacket = 0x90;
constexpr double kP2osPi = std::numbers::pi;
constexpr i32 kSonarMax = 5000;  // mm

// Directions of the sonars, deg, clockwise from straight ahead.
constexpr std::array<int, kP2osSonars> kSonarAngles = {-90, -50, -30, -10, 10,  30,  50,  90,
                                                       90,  130, 150, 170, 190, 210, 230, 270};

P2osPacket framed(std::span<const std::byte> body) {
  P2osPacket packet;
  packet.bytes[0] = kHead1;
  packet.bytes[1] = kHead2;
  packet.bytes[2] = static_cast<std::byte>(body.size() + 2);
  std::ranges::copy(body, packet.bytes.begin() + kFrame);
  const unsigned sum = p2os_checksum(body);
  packet.bytes[kFrame + body.size()] = static_cast<std::byte>(sum >> 8);
  packet.bytes[kFrame + body.size() + 1] = static_cast<std::byte>(sum);
  packet.size = kFrame + body.size() + 2;
  return packet;
}

}  // namespace

std::uint16_t p2os_checksum(std::span<const std::byte> body) {
  unsigned sum = 0;
  for (std::size_t i = 0; i + 1 < body.size(); i += 2)
    sum += static_cast<unsigned>(byte_at(body, i) << 8 | byte_at(body, i + 1));
  if (body.size() % 2 != 0) sum ^= std::to_integer<unsigned>(body.back());
  return static_cast<std::uint16_t>(sum);
}

P2osPacket p2os_command(P2osCommand command, std::optional<int> argument) {
  const auto number = static_cast<std::byte>(command);
  if (!argument) return framed(std::array{number});
  constexpr std::byte kPositive{0x3B};
  constexpr std::byte kNegative{0x1B};
  const unsigned size = static_cast<unsigned>(std::min(std::abs(*argument), 0x7FFF));
  return framed(std::array{number, *argument < 0 ? kNegative : kPositive,
                           static_cast<std::byte>(size), static_cast<std::byte>(size >> 8)});
}

P2osPacket p2os_sync(int number) { return framed(std::array{static_cast<std::byte>(number)}); }

bool P2osPackets::next(Packet& packet) {
  buffer_.consume(std::exchange(used_, 0));
  while (buffer_.size() >= kFrame) {
    const auto bytes = buffer_.bytes();
    const std::size_t size = std::to_integer<std::size_t>(bytes[2]);
    if (bytes[0] != kHead1 || bytes[1] != kHead2 || size < 3) {
      buffer_.consume(1);
      continue;
    }
    if (bytes.size() < kFrame + size) return false;
    const auto body = bytes.subspan(kFrame, size - 2);
    if (p2os_checksum(body) != big_endian<std::uint16_t>(bytes, kFrame + size - 2)) {
      ++broken_;
      buffer_.consume(1);
      continue;
    }
    packet = {.body = body, .began = buffer_.time_of(0)};
    used_ = kFrame + size;
    return true;
  }
  return false;
}

bool decode_p2os_state(std::span<const std::byte> body, P2osState& state) {
  constexpr std::size_t kSonarCount = 19;
  if (body.size() <= kSonarCount || (byte_at(body, 0) & 0xF0) != 0x30) return false;
  state.is_moving = byte_at(body, 0) == 0x33;
  // The highest bit is not part of the number.
  const auto place = [&](std::size_t index) {
    const int value = little_endian<std::uint16_t>(body, index) & 0x7FFF;
    return value >= 0x4000 ? value - 0x8000 : value;
  };
  state.x = place(1);
  state.y = place(3);
  state.heading = little_endian<std::int16_t>(body, 5);
  state.left = little_endian<std::int16_t>(body, 7);
  state.right = little_endian<std::int16_t>(body, 9);
  state.battery = static_cast<float>(byte_at(body, 11)) / 10;
  state.sonar_count = 0;
  const auto count = static_cast<std::size_t>(byte_at(body, kSonarCount));
  for (std::size_t i = 0; i < count && state.sonar_count < kP2osSonars; ++i) {
    const std::size_t where = kSonarCount + 1 + 3 * i;
    if (where + 3 > body.size()) return false;
    state.sonars[state.sonar_count++] = {.number = std::to_integer<std::uint8_t>(body[where]),
                                         .range = little_endian<std::uint16_t>(body, where + 1)};
  }
  return true;
}

// --- the dialogue

P2os::P2os(const P2osSettings& settings) : settings_(settings) {
  rays_.points.resize(kP2osSonars);
  for (std::size_t i = 0; i < kP2osSonars; ++i) {
    rays_.points[i].angle = static_cast<f32>(kSonarAngles[i] * kP2osPi / 180);
    rays_.points[i].type = ladar_point::kInvalid;
  }
  rays_.startAngle = static_cast<f32>(-kP2osPi / 2);
  rays_.endAngle = static_cast<f32>(kP2osPi * 3 / 2);
  rays_.maxRange = kSonarMax;
  rays_.duration = 100U;
}

void P2os::start(Time now, Output& out) {
  clear_failure();
  packets_.clear();
  encoders_.reset();
  pose_.reset();
  distances_ = {};
  has_data_ = has_sonars_ = false;
  recorded_before_ = {};
  wanted_speed_ = wanted_turn_ = 0;
  if (settings_.only_listen) {
    state_ = State::kOpen;
    timer_.reset();
    return;
  }
  out.set_baud(kP2osBaud);
  enter(State::kSync0, now);
}

void P2os::enter(State state, Time now) {
  state_ = state;
  step_ = 0;
  timer_.reset();
  timer_.wait_until(now + kP2osBetween);
  sent_speed_.reset();
  sent_turn_.reset();
}

void P2os::on_timeout(Time now, Output& out) {
  if (!timer_.take_due(now)) return;
  switch (state_) {
    case State::kSync0:
    case State::kSync1:
    case State::kSync2:
      if (!timer_.may_repeat(kP2osAttempts))
        return fail(
            tims::Errc::kTimeout,
            "the robot does not answer to SYNC; check its power and that its serial line is free");
      out.send(p2os_sync(static_cast<int>(state_)).view());
      timer_.sent(now, kP2osAnswerTime);
      // After three attempts the sequence starts again with SYNC 0.
      if (timer_.attempts() % 3 == 0) state_ = State::kSync0;
      return;
    case State::kSetup:
      send_setup(now, out);
      return;
    case State::kOpen:
      send_speed(now, out);
      return;
  }
}

void P2os::send(const P2osPacket& packet, Time now, Output& out) {
  out.send(packet.view());
  timer_.wait_until(now + kP2osBetween);
}

// Sends one command per call. The last one enables the motors.
void P2os::send_setup(Time now, Output& out) {
  using Command = P2osCommand;
  switch (step_++) {
    case 0:
      return send(p2os_command(Command::kOpen), now, out);
    case 1:
      return send(p2os_command(Command::kPulse), now, out);
    case 2:
      return send(p2os_command(Command::kSonar, settings_.sonar ? 1 : 0), now, out);
    case 3:
      return send(p2os_command(Command::kEncoder, 2), now, out);
    case 4:
      if (settings_.acceleration > 0)
        return send(p2os_command(Command::kSetAcceleration, settings_.acceleration), now, out);
      break;
    case 5:
      if (settings_.deceleration > 0)
        return send(p2os_command(Command::kSetAcceleration, -settings_.deceleration), now, out);
      break;
    case 6:
      return send(p2os_command(Command::kVelocity, 0), now, out);
    case 7:
      return send(p2os_command(Command::kEnable, 1), now, out);
    default:
      enter(State::kOpen, now);
      return;
  }
  timer_.wait_until(now);
}

void P2os::drive(const ChassisSpeed& speed, Time now) {
  wanted_speed_ = static_cast<int>(std::lround(speed.vx));
  wanted_turn_ = static_cast<int>(std::lround(-static_cast<double>(speed.omega) * 180 / kP2osPi));
  if (state_ != State::kOpen || settings_.only_listen) return;
  const bool has_changed = sent_speed_ != wanted_speed_ || sent_turn_ != wanted_turn_;
  if (has_changed)
    timer_.wait_until(std::min(timer_.due(), std::max(now, repeat_ - kRepeat + kP2osBetween)));
}

// Sends changed speeds, and repeats all of them periodically, which also feeds the watchdog.
void P2os::send_speed(Time now, Output& out) {
  if (now >= repeat_) {
    sent_speed_.reset();
    sent_turn_.reset();
  }
  if (sent_speed_ != wanted_speed_) {
    sent_speed_ = wanted_speed_;
    send(p2os_command(P2osCommand::kVelocity, wanted_speed_), now, out);
  } else if (sent_turn_ != wanted_turn_) {
    sent_turn_ = wanted_turn_;
    send(p2os_command(P2osCommand::kTurn, wanted_turn_), now, out);
  } else {
    timer_.wait_until(repeat_);
    return;
  }
  repeat_ = now + kRepeat;
  if (sent_speed_ == wanted_speed_ && sent_turn_ == wanted_turn_) timer_.wait_until(repeat_);
}

void P2os::stop(Time, Output& out) {
  if (settings_.only_listen) return;
  using Command = P2osCommand;
  out.send(p2os_command(Command::kVelocity, 0).view());
  out.send(p2os_command(Command::kTurn, 0).view());
  out.send(p2os_command(Command::kEnable, 0).view());
  out.send(p2os_command(Command::kClose).view());
  timer_.stop();
}

void P2os::on_arrival(const Arrival& arrival, Output&) {
  packets_.add(arrival);
  P2osPackets::Packet packet;
  while (packets_.next(packet)) on_packet(packet, arrival.last);
}

void P2os::on_packet(const P2osPackets::Packet& packet, Time now) {
  if (packet.body.empty()) return;
  const int what = byte_at(packet.body, 0);
  P2osState state;
  if (decode_p2os_state(packet.body, state)) {
    // The robot was opened before and not closed: it needs no SYNC.
    if (state_ < State::kSetup) enter(State::kSetup, now);
    if (state_ == State::kOpen) on_state(state, packet.began);
  } else if (what == kEncoderPacket && packet.body.size() >= 9) {
    on_encoders(packet.body);
  } else if (state_ < State::kSetup && what == static_cast<int>(state_)) {
    on_sync(packet.body, now);
  }
}

void P2os::on_sync(std::span<const std::byte> body, Time now) {
  if (state_ == State::kSync2) {
    robot_.clear();
    for (const std::byte byte : body.subspan(1)) {
      const char character = std::to_integer<char>(byte);
      robot_ += character == '\0' ? ' ' : character;
    }
    while (!robot_.empty() && robot_.back() == ' ') robot_.pop_back();
  }
  enter(static_cast<State>(static_cast<int>(state_) + 1), now);
}

void P2os::on_encoders(std::span<const std::byte> body) {
  const std::array now{little_endian<std::int32_t>(body, 1), little_endian<std::int32_t>(body, 5)};
  if (encoders_) {
    for (std::size_t i = 0; i < 2; ++i) {
      const auto ticks = static_cast<std::int32_t>(static_cast<std::uint32_t>(now[i]) -
                                                   static_cast<std::uint32_t>((*encoders_)[i]));
      distances_[i] += ticks / settings_.ticks_per_mm;
    }
  }
  encoders_ = now;
}

void P2os::on_state(const P2osState& state, Time began) {
  recorded_ = began;
  if (encoders_) {
    data_.deltaX = data_.deltaX + static_cast<f32>((distances_[0] + distances_[1]) / 2);
    data_.deltaRho = data_.deltaRho +
                     static_cast<f32>((distances_[0] - distances_[1]) / settings_.rotation_width);
    distances_ = {};
  } else if (pose_) {
    // Transforms the odometry of the robot into its body frame.
    const auto wrapped = [](int difference, int turn) {
      return (difference + 3 * turn / 2) % turn - turn / 2;
    };
    const double heading = (*pose_)[2] * 2 * kP2osPi / 4096;
    const double dx = wrapped(state.x - (*pose_)[0], 0x8000);
    const double dy = wrapped(state.y - (*pose_)[1], 0x8000);
    data_.deltaX = data_.deltaX + static_cast<f32>(dx * std::cos(heading) + dy * std::sin(heading));
    data_.deltaRho = data_.deltaRho + static_cast<f32>(-wrapped(state.heading - (*pose_)[2], 4096) *
                                                       2 * kP2osPi / 4096);
  }
  pose_ = {state.x, state.y, state.heading};
  data_.vx = (state.left + state.right) / 2;
  data_.omega = (state.left - state.right) / static_cast<float>(settings_.rotation_width);
  data_.battery = state.battery;
  has_data_ = true;
  for (std::size_t i = 0; i < state.sonar_count; ++i) {
    const auto [number, range] = state.sonars[i];
    if (number >= kP2osSonars) continue;
    LadarPoint& ray = rays_.points[number];
    ray.distance = static_cast<i32>(std::lround(range * settings_.sonar_scale));
    ray.type = ray.distance >= kSonarMax ? ladar_point::kInvalid : ladar_point::kUnknown;
    has_sonars_ = true;
  }
}

bool P2os::take(ChassisData& data, Time& recorded) {
  if (!std::exchange(has_data_, false)) return false;
  data = data_;
  data_.deltaX = 0;
  data_.deltaRho = 0;
  recorded = recorded_;
  return true;
}

bool P2os::take_sonars(LadarData& rays, Time& recorded) {
  if (!std::exchange(has_sonars_, false)) return false;
  rays = rays_;
  recorded = recorded_;
  return true;
}

}  // namespace rack::device
