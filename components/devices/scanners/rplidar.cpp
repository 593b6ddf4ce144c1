#include "components/devices/scanners/rplidar.h"

#include "base/text.h"
#include "rack/devices/device_clock.h"

namespace rack::device {
namespace {

using namespace std::chrono_literals;
using rplidar::kConfigurationAnswer;

constexpr std::array<std::uint32_t, 4> kRplidarRates = {115200, 256000, 460800, 1'000'000};
constexpr int kAttemptsAtRate = 2;
constexpr int kRplidarAttempts = 4;
constexpr Duration kPauseOfStop = 20ms;
constexpr Duration kPauseOfReset = 2s;
constexpr Duration kRplidarAnswerTime = 200ms;
// Includes the spin-up of the motor.
constexpr Duration kRplidarSpinUp = 5s;
constexpr std::uint16_t kFirmwareOfExpress = 0x0111;
constexpr std::uint16_t kFirmwareOfConfiguration = 0x0118;
constexpr unsigned kMotorSpeed = 660;  // of 1023, recommended by the manual
constexpr i32 kRplidarRangeMin = 50;   // mm
constexpr i32 kRangeOfOld = 12'000;
constexpr std::uint8_t kIsBroken = 2;

std::array<std::byte, 2> bytes_of(unsigned number) {
  return {static_cast<std::byte>(number & 0xFF), static_cast<std::byte>(number >> 8)};
}

}  // namespace

Rplidar::Rplidar(const RplidarSettings& settings) : settings_(settings) {
  constexpr std::size_t kLongest = 64;
  question_.reserve(kLongest);
}

void Rplidar::start(Time now, Output& out) {
  clear_failure();
  packets_.clear();
  points_.clear();
  scan_.clear();
  scan_.set_range(kRplidarRangeMin, kRangeOfOld);
  was_reset_ = false;
  info_ = {};
  type_ = rplidar::kPoints;
  if (settings_.only_listen) {
    state_ = State::kMeasuring;
    timer_.reset();
    return;
  }
  rate_index_ = 0;
  rate_ = settings_.baud;
  out.set_baud(rate_);
  // The motor of the A1 runs while DTR is off.
  out.set_dtr(false);
  enter(State::kStop, now, out);
}

void Rplidar::stop(Time, Output& out) {
  if (settings_.only_listen) return;
  send(rplidar::kStop, {}, out);
  if (has_motor_command()) send(rplidar::kMotor, bytes_of(0), out);
  out.set_dtr(true);
}

bool Rplidar::has_motor_command() const {
  const int series = info_.model >> 4;
  return series == 2 || series == 3;
}

void Rplidar::turn_motor_on(Output& out) {
  constexpr int kFirstWithSpeed = 4;
  if (has_motor_command())
    send(rplidar::kMotor, bytes_of(kMotorSpeed), out);
  else if (settings_.turns_a_minute > 0 && info_.model >> 4 >= kFirstWithSpeed)
    send(rplidar::kSpeed, bytes_of(static_cast<unsigned>(settings_.turns_a_minute)), out);
}

void Rplidar::send(std::uint8_t command, std::span<const std::byte> payload, Output& out) {
  question_.clear();
  append_rplidar(question_, command, payload);
  out.send(question_);
}

void Rplidar::enter(State state, Time now, Output& out) {
  state_ = state;
  timer_.reset();
  ask(now, out);
}

void Rplidar::ask_configuration(std::uint32_t entry, bool with_mode) {
  std::array<std::byte, 6> payload{};
  for (std::size_t i = 0; i < 4; ++i) payload[i] = static_cast<std::byte>(entry >> 8 * i);
  payload[4] = static_cast<std::byte>(mode_ & 0xFF);
  payload[5] = static_cast<std::byte>(mode_ >> 8);
  append_rplidar(question_, rplidar::kConfiguration, std::span(payload).first(with_mode ? 6 : 4));
}

void Rplidar::ask(Time now, Output& out) {
  question_.clear();
  Duration pause = kRplidarAnswerTime;
  const std::array express = {static_cast<std::byte>(mode_), std::byte{}, std::byte{}, std::byte{},
                              std::byte{}};
  switch (state_) {
    case State::kStop:
      append_rplidar(question_, rplidar::kStop);
      pause = kPauseOfStop;
      break;
    case State::kInfo:
      append_rplidar(question_, rplidar::kInfo);
      break;
    case State::kHealth:
      append_rplidar(question_, rplidar::kHealth);
      break;
    case State::kReset:
      append_rplidar(question_, rplidar::kReset);
      pause = kPauseOfReset;
      break;
    case State::kMode:
      ask_configuration(rplidar::kTypicalMode, false);
      break;
    case State::kType:
      ask_configuration(rplidar::kAnswerOfMode, true);
      break;
    case State::kRange:
      ask_configuration(rplidar::kRangeOfMode, true);
      break;
    case State::kScan:
      if (type_ == rplidar::kPoints)
        append_rplidar(question_, rplidar::kScan);
      else
        append_rplidar(question_, rplidar::kExpress, express);
      pause = kRplidarSpinUp;
      break;
    case State::kMeasuring:
      break;
  }
  out.send(question_);
  timer_.sent(now, pause + (settings_.has_rate ? line_time(question_.size(), rate_) : Duration(0)));
}

void Rplidar::on_timeout(Time now, Output& out) {
  if (!timer_.take_due(now)) return;
  if (state_ == State::kStop) {
    // Discards bytes that were in transit, and noise received at a wrong rate.
    packets_.clear();
    points_.clear();
    enter(State::kInfo, now, out);
  } else if (state_ == State::kReset) {
    enter(State::kStop, now, out);
  } else {
    retry(now, out);
  }
}

void Rplidar::retry(Time now, Output& out) {
  const int allowed = state_ == State::kInfo   ? kAttemptsAtRate
                      : state_ >= State::kScan ? 1
                                               : kRplidarAttempts;
  if (timer_.may_repeat(allowed)) return ask(now, out);
  if (state_ == State::kInfo) return try_next_rate(now, out);
  // Some scanners do not support requests that their firmware version suggests: treat them as old
  // ones.
  if (state_ == State::kMode || state_ == State::kType || state_ == State::kRange) {
    if (state_ != State::kRange) type_ = rplidar::kPoints;
    return enter(State::kScan, now, out);
  }
  fail(tims::Errc::kTimeout,
       state_ >= State::kScan ? "the scanner sends no complete turn; check its motor and 5 V supply"
                              : "the scanner has stopped answering");
}

void Rplidar::try_next_rate(Time now, Output& out) {
  while (settings_.has_rate && rate_index_ < kRplidarRates.size()) {
    const std::uint32_t rate = kRplidarRates[rate_index_++];
    if (rate == settings_.baud) continue;
    rate_ = rate;
    out.set_baud(rate_);
    enter(State::kStop, now, out);
    return;
  }
  fail(tims::Errc::kTimeout,
       settings_.has_rate ? "no RPLIDAR answers, neither at " + std::to_string(settings_.baud) +
                                " baud nor at another RPLIDAR rate; check its power and "
                                "parameter model"
                          : "no RPLIDAR answers");
}

void Rplidar::on_arrival(const Arrival& arrival, Output& out) {
  packets_.add(arrival);
  RplidarPacket packet;
  while (packets_.next(packet)) {
    take_packet(packet, arrival.last, out);
    if (failure()) return;
  }
}

void Rplidar::take_packet(const RplidarPacket& packet, Time now, Output& out) {
  if (packet.type >= rplidar::kPoints) {
    if (state_ != State::kScan && state_ != State::kMeasuring) return;
    state_ = State::kMeasuring;
    points_.decode(packet, scan_);
    if (is_ready()) timer_.stop();
  } else if (packet.type == rplidar::kInfoAnswer && state_ == State::kInfo) {
    on_info(packet, now, out);
  } else if (packet.type == rplidar::kHealthAnswer && state_ == State::kHealth) {
    on_health(packet, now, out);
  } else if (packet.type == kConfigurationAnswer) {
    take_configuration(packet, now, out);
  }
}

void Rplidar::on_info(const RplidarPacket& packet, Time now, Output& out) {
  constexpr std::size_t kSize = 20;
  if (packet.data.size() != kSize) return;
  info_.model = static_cast<std::uint8_t>(packet.data[0]);
  info_.firmware = little_endian<std::uint16_t>(packet.data, 1);
  info_.hardware = static_cast<std::uint8_t>(packet.data[3]);
  info_.serial_number = tims::base::to_hex(packet.data.subspan(4));
  if (is_wanted("scanner", info_.serial_number, settings_.serial_number))
    enter(State::kHealth, now, out);
}

void Rplidar::on_health(const RplidarPacket& packet, Time now, Output& out) {
  if (packet.data.size() < 3) return;
  if (static_cast<std::uint8_t>(packet.data[0]) == kIsBroken) {
    if (!was_reset_) {
      was_reset_ = true;
      enter(State::kReset, now, out);
      return;
    }
    fail(tims::Errc::kSystem, "the scanner reports a defect, error " +
                                  std::to_string(little_endian<std::uint16_t>(packet.data, 1)));
    return;
  }
  turn_motor_on(out);
  mode_ = 0;
  type_ = settings_.only_points || info_.firmware < kFirmwareOfExpress ? rplidar::kPoints
                                                                       : rplidar::kPairs;
  const bool can_choose = type_ != rplidar::kPoints && info_.firmware >= kFirmwareOfConfiguration;
  enter(can_choose ? State::kMode : State::kScan, now, out);
}

void Rplidar::take_configuration(const RplidarPacket& packet, Time now, Output& out) {
  if (packet.data.size() < 5) return;
  const std::uint32_t entry = little_endian<std::uint32_t>(packet.data);
  const auto data = packet.data.subspan(4);
  if (state_ == State::kMode && entry == rplidar::kTypicalMode && data.size() >= 2) {
    mode_ = little_endian<std::uint16_t>(data);
    enter(State::kType, now, out);
  } else if (state_ == State::kType && entry == rplidar::kAnswerOfMode) {
    type_ = static_cast<std::uint8_t>(data[0]);
    const bool is_known = type_ == rplidar::kPoints || type_ == rplidar::kPairs ||
                          type_ == rplidar::kTriples || type_ == rplidar::kDense;
    if (!is_known) type_ = rplidar::kPoints;
    enter(State::kRange, now, out);
  } else if (entry == rplidar::kRangeOfMode && data.size() >= 4) {
    constexpr double kOfMetre = 256;
    const double metres = little_endian<std::uint32_t>(data) / kOfMetre;
    scan_.set_range(kRplidarRangeMin, static_cast<i32>(1000 * metres));
    if (state_ == State::kRange) enter(State::kScan, now, out);
  }
}

}  // namespace rack::device
