#include "components/devices/positioning/cmps03.h"

#include <cmath>
#include <cstring>
#include <numbers>

#include "base/text.h"
#include "rack/devices/pieces.h"

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr double kCmps03Degree = std::numbers::pi / 180;
constexpr f32 kAccuracy = static_cast<f32>(3.5 * kCmps03Degree);
constexpr f32 kUnknown = static_cast<f32>(std::numbers::pi);
constexpr Duration kCmps03FirstData = 5s;
constexpr Duration kConfirmTime = 3s;
constexpr std::size_t kPieceMax = 512;

}  // namespace

std::optional<double> parse_cmps03(std::string_view line) {
  constexpr std::size_t kSize = 5;
  constexpr int kTurn = 3600;
  if (line.size() != kSize || line.front() != '$') return std::nullopt;
  const auto tenths = tims::base::parse_number<int>(line.substr(1));
  if (!tenths || *tenths < 0 || *tenths > kTurn) return std::nullopt;
  return *tenths / 10.0;
}

void Cmps03::start(Time now, Output&) {
  clear_failure();
  buffer_.clear();
  state_ = State::kMeasuring;
  step_ = Step::kNone;
  ask_ = has_received_ = has_data_ = false;
  bytes_ = 0;
  timer_.wait_until(now + kCmps03FirstData);
}

void Cmps03::on_arrival(const Arrival& arrival, Output& out) {
  bytes_ += arrival.bytes.size();
  in_pieces(arrival, kPieceMax, [&](const Arrival& piece) {
    buffer_.add(piece);
    for (;;) {
      const auto bytes = buffer_.bytes();
      const auto* const text = reinterpret_cast<const char*>(bytes.data());
      const auto* const end =
          bytes.empty() ? nullptr : static_cast<const char*>(std::memchr(text, '\n', bytes.size()));
      if (end == nullptr) break;
      std::string_view line(text, static_cast<std::size_t>(end - text));
      const std::size_t size = line.size() + 1;
      // A truncated line may be followed by a complete one.
      const std::size_t begin = std::min(line.rfind('$'), line.size());
      line.remove_prefix(begin);
      if (line.ends_with('\r')) line.remove_suffix(1);
      on_line(line, buffer_.time_of(begin), piece.last, out);
      buffer_.consume(size);
    }
    forget_noise();
  });
}

// Without a line end, keeps only bytes that may become a line.
void Cmps03::forget_noise() {
  if (buffer_.size() <= kLineMax) return;
  const auto bytes = buffer_.bytes();
  std::size_t begin = bytes.size();
  while (begin > 0 && bytes[begin - 1] != std::byte{'$'}) --begin;
  if (begin > 0) --begin;
  buffer_.consume(begin > 0 ? begin : bytes.size());
}

void Cmps03::on_line(std::string_view line, Time began, Time, Output& out) {
  constexpr std::size_t kShort = 16;
  if (line.starts_with("$OK") && line.size() <= kShort) {
    if (state_ == State::kAsked) on_confirmed(out);
    return;
  }
  const auto degrees = parse_cmps03(line);
  if (!degrees) return;
  constexpr double kTurn = 360;
  const double sum = *degrees + settings_.offset;
  const double turned = sum >= 0 && sum < kTurn ? sum : std::fmod(sum, kTurn);
  data_.orientation = static_cast<f32>((turned < 0 ? turned + 360 : turned) * kCmps03Degree);
  // During the calibration the heading is undefined.
  data_.varOrientation = is_calibrating() ? kUnknown : kAccuracy;
  recorded_ = began;
  has_data_ = has_received_ = true;
}

void Cmps03::on_confirmed(Output& out) {
  out.send(std::span(&cmps03::kConfirm, 1));
  timer_.stop();
  step_direction_ = direction_;
  if (direction_ == cmps03::kDirections) {
    state_ = State::kMeasuring;
    return set_step(Step::kDone);
  }
  ++direction_;
  state_ = State::kAligning;
  set_step(Step::kConfirmed);
}

void Cmps03::request_calibration(bool wanted, bool aligned, Time now) {
  if (!wanted && is_calibrating()) {
    state_ = State::kMeasuring;
    ask_ = false;
    timer_.stop();
    return set_step(Step::kEnded);
  }
  if (wanted && state_ == State::kMeasuring && step_ != Step::kDone) {
    state_ = State::kAligning;
    direction_ = step_direction_ = 1;
    return set_step(Step::kAlign);
  }
  if (state_ != State::kAligning || !aligned || step_ == Step::kConfirmed || step_ == Step::kSilent)
    return;
  ask_ = true;
  timer_.wait_until(now);
}

void Cmps03::on_timeout(Time now, Output& out) {
  if (!timer_.take_due(now)) return;
  if (std::exchange(ask_, false) && state_ == State::kAligning) {
    out.send(std::span(&cmps03::kCalibrate, 1));
    state_ = State::kAsked;
    return timer_.wait_until(now + kConfirmTime);
  }
  if (state_ == State::kAsked) {
    // Do not repeat the request automatically: the compass might take this direction for the next.
    state_ = State::kAligning;
    step_direction_ = direction_;
    return set_step(Step::kSilent);
  }
  if (has_received_ || is_calibrating()) return;
  fail(tims::Errc::kTimeout,
       bytes_ == 0 ? "the compass sends nothing; check its power and the serial line"
                   : "received data are not headings of a CMPS03 board; check baudrate (57600)");
}

bool Cmps03::take(CompassData& data, Time& recorded) {
  if (!std::exchange(has_data_, false)) return false;
  data = data_;
  recorded = recorded_;
  return true;
}

Cmps03::Step Cmps03::take_step(int& direction) {
  direction = step_direction_;
  return std::exchange(step_, Step::kNone);
}

}  // namespace rack::device
