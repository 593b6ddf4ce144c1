#include "components/devices/scanners/lms200_emulator.h"

#include <algorithm>
#include <numbers>
#include <string_view>

#include "rack/devices/device_clock.h"

namespace rack::device::emulator {
namespace {

constexpr std::uint8_t kAddress = 0x80;  // address of telegrams from the scanner
constexpr std::byte kModeCommand{0x20};
constexpr std::byte kModeAnswer{0xA0};
constexpr std::byte kStatusCommand{0x31};
constexpr std::byte kLms200EmulatorUnknownCommand{0x92};
constexpr std::byte kMeasurement{0xB0};
constexpr std::byte kStatus{0x10};  // last byte of each body: no error
constexpr std::string_view kPassword = "SICK_LMS";

constexpr std::uint8_t kInstallMode = 0x00;
constexpr std::uint8_t kContinuous = 0x24;
constexpr std::uint8_t kOnRequest = 0x25;
constexpr std::uint8_t kContinuousParts = 0x2A;

std::uint32_t rate_of(std::uint8_t mode) {
  switch (mode) {
    case 0x40:
      return 38400;
    case 0x41:
      return 19200;
    case 0x42:
      return 9600;
    case 0x48:
      return 500000;
    default:
      return 0;
  }
}

}  // namespace

void Lms200Emulator::start(Time /*now*/, Output& out) {
  baud_ = settings_.baud;
  mode_ = Mode::kOnRequest;
  is_logged_in_ = false;
  answer_at_ = scan_at_ = tims::kNever;
  telegrams_.clear();
  commands_.clear();
  out.set_baud(baud_);
}

void Lms200Emulator::on_arrival(const Arrival& arrival, Output& out) {
  constexpr std::array kAcknowledged = {std::byte{0x06}};
  constexpr std::array kRefused = {std::byte{0x15}};
  telegrams_.add(arrival);
  const std::uint64_t broken = telegrams_.broken();
  Lms200Telegram telegram;
  for (auto what = telegrams_.next(telegram); what != Lms200Telegrams::What::kNothing;
       what = telegrams_.next(telegram)) {
    if (what != Lms200Telegrams::What::kTelegram) continue;
    out.send(kAcknowledged);
    commands_.emplace_back(telegram.body.begin(), telegram.body.end());
    if (answer_at_ == tims::kNever) answer_at_ = arrival.last + settings_.answer_time;
  }
  if (telegrams_.broken() != broken) out.send(kRefused);
}

void Lms200Emulator::carry_out(std::span<const std::byte> body) {
  next_baud_ = 0;
  next_mode_ = mode_;
  answer_.clear();
  if (body.size() >= 2 && body[0] == kModeCommand) {
    const bool good = switch_mode(body.subspan(1));
    answer_ = {kModeAnswer, good ? std::byte{0} : std::byte{1}, kStatus};
  } else if (body[0] == kStatusCommand) {
    answer_ = {std::byte{0xB1}, kStatus};
  } else {
    answer_ = {kLms200EmulatorUnknownCommand, kStatus};
  }
}

// Switches the mode after the answer.
bool Lms200Emulator::switch_mode(std::span<const std::byte> body) {
  const auto mode = std::to_integer<std::uint8_t>(body[0]);
  if (mode == kInstallMode) {
    const auto password = std::as_bytes(std::span(kPassword));
    is_logged_in_ = std::ranges::equal(body.subspan(1), password);
    return is_logged_in_;
  }
  if (const std::uint32_t rate = rate_of(mode); rate != 0) {
    if (settings_.refuses_rates) return false;
    next_baud_ = rate;
    return true;
  }
  if (mode == kContinuous) next_mode_ = Mode::kWhole;
  if (mode == kContinuousParts) next_mode_ = Mode::kParts;
  if (mode == kOnRequest) next_mode_ = Mode::kOnRequest;
  return mode == kContinuous || mode == kContinuousParts || mode == kOnRequest;
}

void Lms200Emulator::on_timeout(Time now, Output& out) {
  if (answer_at_ <= now) {
    carry_out(commands_.front());
    commands_.pop_front();
    answer_at_ = commands_.empty() ? tims::kNever : now + settings_.answer_time;
    telegram_.clear();
    append_lms200(telegram_, answer_, kAddress);
    out.send(telegram_);
    if (next_baud_ != 0) {
      baud_ = std::exchange(next_baud_, 0);
      out.set_baud(baud_);
    }
    mode_ = next_mode_;
    scan_at_ = mode_ == Mode::kOnRequest ? tims::kNever : now + kLms200Turn;
  }
  if (scan_at_ <= now) send_scan(now, out);
}

// Half-degree scans are measured in two turns, of which the second is shifted by half a degree.
// They are sent as a whole, or turn by turn. The next one is sent when the line is free.
void Lms200Emulator::send_scan(Time now, Output& out) {
  telegram_.clear();
  body_.clear();
  const bool is_second = scans_sent_ % 2 != 0;
  const Time end = scan_at_;
  if (mode_ == Mode::kWhole)
    append_scan(361, 0, -90, 0.5, end);
  else if (is_second)
    append_scan(180, 2U << 11 | 1U << 13, -89.5, 1, end);
  else
    append_scan(181, 1U << 13, -90, 1, end);
  append_lms200(telegram_, body_, kAddress);
  out.send(telegram_);
  ++scans_sent_;
  const Duration busy = line_time(telegram_.size(), baud_);
  const std::int64_t turns = mode_ == Mode::kWhole ? 2 : 1;
  const Duration between = kLms200Turn * std::max(turns, (busy + kLms200Turn) / kLms200Turn);
  while (scan_at_ <= now) scan_at_ += between;
}

// `first`: angle of the first value, counterclockwise from straight ahead, degrees. `end`: when the
// last value was measured; with a step of half a degree, every second value is of the previous
// turn.
void Lms200Emulator::append_scan(std::size_t values, unsigned flags, double first, double step,
                                 Time end) {
  const unsigned unit = settings_.is_indoor ? 1U << 14 : 0;
  const unsigned count_and_flags = static_cast<unsigned>(values) | flags | unit;
  const double most = settings_.is_indoor ? 0x7FF7 : 0x1FF7;
  const double last = static_cast<double>(values - 1) * step;
  body_ = {kMeasurement, static_cast<std::byte>(count_and_flags),
           static_cast<std::byte>(count_and_flags >> 8)};
  for (std::size_t i = 0; i < values; ++i) {
    const double degrees = static_cast<double>(i) * step;
    const double angle = -(first + degrees) * std::numbers::pi / 180;
    const double back = last - degrees + (step < 1 && i % 2 != 0 ? 360 : 0);
    const Time when = end - std::chrono::duration_cast<Duration>(kLms200Turn * (back / 360));
    const double distance = settings_.sight(angle, 0, when) / (settings_.is_indoor ? 1 : 10);
    const auto value = static_cast<unsigned>(std::lround(std::min(distance, most)));
    body_.push_back(static_cast<std::byte>(value));
    body_.push_back(static_cast<std::byte>(value >> 8));
  }
  body_.push_back(kStatus);
}

}  // namespace rack::device::emulator
