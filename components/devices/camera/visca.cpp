#include "components/devices/camera/visca.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace rack::device {
namespace {

using namespace std::chrono_literals;
using visca::Kind;

constexpr std::byte operator""_b(unsigned long long value) { return static_cast<std::byte>(value); }

constexpr std::byte kToCamera = 0x81_b;
constexpr std::byte kFromCamera = 0x90_b;
constexpr int kPanSteps = 24;
constexpr int kTiltSteps = 20;
constexpr int kZoomSteps = 7;
constexpr int kAttempts = 3;
constexpr Duration kAnswerTime = 300ms;
constexpr double kDegree = std::numbers::pi / 180;

std::byte speed_byte(int speed) { return static_cast<std::byte>(std::max(1, std::abs(speed))); }

}  // namespace

namespace visca {

void append_nibbles(std::vector<std::byte>& out, int number) {
  for (int shift = 12; shift >= 0; shift -= 4)
    out.push_back(static_cast<std::byte>(number >> shift & 0xF));
}

int nibbles(std::span<const std::byte> bytes) {
  unsigned number = 0;
  for (const std::byte byte : bytes.first(4))
    number = number << 4 | (std::to_integer<unsigned>(byte) & 0xF);
  return static_cast<std::int16_t>(number);
}

void append_datagram(std::vector<std::byte>& out, Kind kind, std::uint32_t number,
                     std::span<const std::byte> message) {
  const auto code = static_cast<unsigned>(kind);
  for (const unsigned field : {code, static_cast<unsigned>(message.size())})
    for (const int shift : {8, 0}) out.push_back(static_cast<std::byte>(field >> shift));
  for (const int shift : {24, 16, 8, 0}) out.push_back(static_cast<std::byte>(number >> shift));
  out.insert(out.end(), message.begin(), message.end());
}

std::vector<std::byte> stand() {
  return {kToCamera, 0x01_b,    0x06_b, 0x01_b, 0x01_b, 0x01_b, 0x03_b, 0x03_b,
          kEnd,      kToCamera, 0x01_b, 0x04_b, 0x07_b, 0_b,    kEnd};
}

std::optional<Datagram> parse_datagram(std::span<const std::byte> bytes) {
  if (bytes.size() < kHeadBytes || bytes.size() > kHeadBytes + kBytesMax ||
      big_endian<std::uint16_t>(bytes, 2) != bytes.size() - kHeadBytes)
    return std::nullopt;
  return Datagram{.kind = static_cast<Kind>(big_endian<std::uint16_t>(bytes)),
                  .number = big_endian<std::uint32_t>(bytes, 4),
                  .message = bytes.subspan(kHeadBytes)};
}

}  // namespace visca

std::optional<std::span<const std::byte>> ViscaMessages::next() {
  buffer_.consume(std::exchange(used_, 0));
  for (;;) {
    const auto bytes = buffer_.bytes();
    const auto end = std::ranges::find(bytes, visca::kEnd);
    if (end == bytes.end()) {
      if (bytes.size() > visca::kBytesMax) buffer_.consume(bytes.size() - visca::kBytesMax);
      return std::nullopt;
    }
    const auto size = static_cast<std::size_t>(end - bytes.begin()) + 1;
    // Only the first and the last byte have their highest bit set: skips noise before the first.
    std::size_t begin = size - 1;
    while (begin > 0 && (bytes[begin - 1] & 0x80_b) == 0_b) --begin;
    begin -= begin > 0 ? 1 : 0;
    if (size - begin < 3 || size - begin > visca::kBytesMax) {
      buffer_.consume(size);
      continue;
    }
    used_ = size;
    return bytes.subspan(begin, size - begin);
  }
}

void Visca::start(Time now, Output& out) {
  clear_failure();
  messages_.clear();
  commands_.clear();
  target_.reset();
  is_ready_ = settings_.only_listen;
  is_reached_ = has_data_ = overdue_ = false;
  deadline_.forget();
  refused_ = 0;
  timer_.reset();
  asked_ = Asked::kNothing;
  next_question_ = settings_.only_listen ? tims::kNever : now;
  if (settings_.only_listen) return;
  begin(out);
  ask(Asked::kPanTilt, now, out);
}

// Discards the state of a previous connection: resets sequence numbers, assigns the addresses of
// cameras and clears their buffers.
void Visca::begin(Output& out) {
  constexpr std::array kReset = {0x01_b};
  constexpr std::array kSetAddress = {0x88_b, 0x30_b, 0x01_b, visca::kEnd};
  constexpr std::array kClear = {0x88_b, 0x01_b, 0x00_b, 0x01_b, visca::kEnd};
  number_ = 0;
  if (settings_.is_datagrams) {
    send(Kind::kControl, kReset, out);
    number_ = 0;
  } else {
    send(Kind::kCommand, kSetAddress, out);
    send(Kind::kCommand, kClear, out);
  }
}

// Stops the motors, independent of pending commands.
void Visca::stop(Time, Output& out) {
  if (settings_.only_listen || !is_ready_) return;
  commands_.clear();
  turn(0, 0, 0);
  send_commands(out);
}

// Datagrams have sequence numbers, which the guard does not know, so there are none for UDP.
std::vector<Telegram> Visca::stop_commands() const {
  if (settings_.is_datagrams) return {};
  return {{.bytes = visca::stand()}};
}

void Visca::send(Kind kind, std::span<const std::byte> message, Output& out) {
  if (!settings_.is_datagrams) {
    out.send(message);
    return;
  }
  sending_.clear();
  visca::append_datagram(sending_, kind, number_++, message);
  out.send(sending_);
}

Time Visca::next_timeout() const {
  if (!commands_.empty() && is_ready_) return Time{};
  return std::min(deadline_.due(), timer_.due());
}

void Visca::on_timeout(Time now, Output& out) {
  if (settings_.only_listen || failure()) return;
  if (deadline_.due() <= now) {
    overdue_ = true;
    turn(0, 0, 0);
  }
  if (is_ready_) send_commands(out);
  if (!timer_.take_due(now)) return;
  if (!timer_.may_repeat(kAttempts)) {
    asked_ = Asked::kNothing;
    return fail(
        tims::Errc::kTimeout,
        "the camera does not answer; check its power and that it is set to VISCA (9600 baud)");
  }
  if (!is_ready_) begin(out);
  ask(asked_ == Asked::kNothing ? Asked::kPanTilt : asked_, now, out);
}

void Visca::ask(Asked what, Time now, Output& out) {
  constexpr std::array kPanTilt = {kToCamera, 0x09_b, 0x06_b, 0x12_b, visca::kEnd};
  constexpr std::array kZoom = {kToCamera, 0x09_b, 0x04_b, 0x47_b, visca::kEnd};
  if (what == Asked::kPanTilt) next_question_ = now + settings_.period;
  asked_ = what;
  timer_.sent(now, kAnswerTime);
  send(Kind::kQuestion, what == Asked::kZoom ? kZoom : kPanTilt, out);
}

void Visca::send_commands(Output& out) {
  for (std::span<const std::byte> rest = commands_; !rest.empty();) {
    const auto size =
        static_cast<std::size_t>(std::ranges::find(rest, visca::kEnd) - rest.begin()) + 1;
    send(Kind::kCommand, rest.first(size), out);
    rest = rest.subspan(size);
  }
  commands_.clear();
}

void Visca::on_arrival(const Arrival& arrival, Output& out) {
  if (settings_.is_datagrams) {
    const auto datagram = visca::parse_datagram(arrival.bytes);
    if (datagram && datagram->kind == Kind::kReply && !datagram->message.empty() &&
        datagram->message.back() == visca::kEnd)
      on_message(datagram->message, arrival.last, out);
    return;
  }
  messages_.add(arrival);
  while (const auto message = messages_.next()) on_message(*message, arrival.last, out);
}

void Visca::on_message(std::span<const std::byte> message, Time when, Output& out) {
  if (message.size() < 3 || message.front() != kFromCamera) return;
  const auto body = message.subspan(1, message.size() - 2);
  const std::byte kind = body.front() & 0xF0_b;
  if (kind == 0x60_b) ++refused_;
  if (kind == 0x50_b && body.size() > 1) on_answer(body.subspan(1), when, out);
}

// Two numbers are pan and tilt; one number is the zoom.
void Visca::on_answer(std::span<const std::byte> body, Time when, Output& out) {
  const bool is_own = settings_.only_listen;
  if (body.size() == 8 && (asked_ == Asked::kPanTilt || is_own)) {
    now_.pan = visca::nibbles(body);
    now_.tilt = visca::nibbles(body.subspan(4));
    recorded_ = when;
    timer_.reset();
    if (!is_own) ask(Asked::kZoom, when, out);
  } else if (body.size() == 4 && (asked_ == Asked::kZoom || is_own)) {
    now_.zoom = visca::nibbles(body);
    asked_ = Asked::kNothing;
    timer_.reset();
    timer_.wait_until(next_question_);
    is_ready_ = has_data_ = true;
    constexpr int kNear = 3;  // steps
    const auto is_there = [](int is, int wanted) { return std::abs(is - wanted) <= kNear; };
    if (target_ && is_there(now_.pan, target_->pan) && is_there(now_.tilt, target_->tilt) &&
        std::abs(now_.zoom - target_->zoom) <= settings_.zoom_max / 200) {
      target_.reset();
      is_reached_ = true;
    }
    const double step = kDegree / settings_.steps_of_degree;
    data_.posPan = static_cast<f32>(now_.pan * step);
    data_.posTilt = static_cast<f32>(now_.tilt * step);
    data_.posZoom = static_cast<f32>(now_.zoom * 100 / settings_.zoom_max);
  }
}

void Visca::queue(std::span<const std::byte> command) {
  commands_.insert(commands_.end(), command.begin(), command.end());
}

void Visca::home() {
  constexpr std::array kHome = {kToCamera, 0x01_b, 0x06_b, 0x04_b, visca::kEnd};
  constexpr std::array kWide = {kToCamera, 0x01_b, 0x04_b, 0x47_b, 0_b, 0_b, 0_b, 0_b, visca::kEnd};
  queue(kHome);
  queue(kWide);
  target_ = Target{};
  deadline_.end();
}

int Visca::speed(double velocity, double velocity_max, int steps) const {
  const double share = velocity_max > 0 ? velocity / velocity_max : 0;
  if (!(std::abs(share) > 0)) return 0;
  const double step = std::clamp(std::ceil(std::abs(share) * steps), 1.0, 1.0 * steps);
  return static_cast<int>(share < 0 ? -step : step);
}

// A speed limit of 0 means no limit. The camera determines the accelerations.
void Visca::move_to(const PtzDriveMovePosData& move) {
  const auto limit = [&](double velocity, double most, int steps) {
    return speed(velocity > 0 ? velocity : most, most, steps);
  };
  const auto steps = [&](double radians) {
    const double count = radians / kDegree * settings_.steps_of_degree;
    return std::isfinite(count)
               ? static_cast<int>(std::lround(std::clamp(count, -32767.0, 32767.0)))
               : 0;
  };
  const double zoom = std::isfinite(move.posZoom.raw()) ? move.posZoom.raw() : 0;
  Target target{.pan = steps(move.posPan),
                .tilt = steps(move.posTilt),
                .zoom = static_cast<int>(
                    std::lround(std::clamp(zoom / 100 * settings_.zoom_max, 0.0, 32767.0)))};
  const int pan = limit(move.velPan, settings_.pan_speed_max * kDegree, kPanSteps);
  const int tilt = limit(move.velTilt, settings_.tilt_speed_max * kDegree, kTiltSteps);
  std::vector<std::byte>& out = commands_;
  for (const std::byte byte :
       {kToCamera, 0x01_b, 0x06_b, 0x02_b, speed_byte(pan), speed_byte(tilt)})
    out.push_back(byte);
  visca::append_nibbles(out, target.pan);
  visca::append_nibbles(out, target.tilt);
  for (const std::byte byte : {visca::kEnd, kToCamera, 0x01_b, 0x04_b, 0x47_b}) out.push_back(byte);
  visca::append_nibbles(out, target.zoom);
  out.push_back(visca::kEnd);
  target_ = target;
  deadline_.end();
}

void Visca::move(const PtzDriveMoveVelData& move, Time now) {
  const int pan = speed(move.velPan, settings_.pan_speed_max * kDegree, kPanSteps);
  const int tilt = speed(move.velTilt, settings_.tilt_speed_max * kDegree, kTiltSteps);
  const int zoom = speed(move.velZoom, settings_.zoom_speed_max, kZoomSteps + 1);
  turn(pan, tilt, zoom);
  if (pan != 0 || tilt != 0 || zoom != 0) deadline_.on_move(now);
}

void Visca::turn(int pan, int tilt, int zoom) {
  deadline_.end();
  const std::byte pan_direction = pan == 0 ? 0x03_b : pan < 0 ? 0x01_b : 0x02_b;
  const std::byte tilt_direction = tilt == 0 ? 0x03_b : tilt > 0 ? 0x01_b : 0x02_b;
  const int zoom_step = std::max(0, std::abs(zoom) - 1);
  const std::byte zoom_direction =
      zoom == 0 ? 0_b : static_cast<std::byte>((zoom > 0 ? 0x20 : 0x30) | zoom_step);
  queue(std::array{kToCamera, 0x01_b, 0x06_b, 0x01_b, speed_byte(pan), speed_byte(tilt),
                   pan_direction, tilt_direction, visca::kEnd});
  queue(std::array{kToCamera, 0x01_b, 0x04_b, 0x07_b, zoom_direction, visca::kEnd});
  target_.reset();
}

bool Visca::take(PtzDriveData& data, Time& recorded) {
  if (!std::exchange(has_data_, false)) return false;
  data = data_;
  recorded = recorded_;
  return true;
}

bool Visca::take_reached() { return std::exchange(is_reached_, false); }

}  // namespace rack::device
