#include "components/devices/scanners/lms200.h"

#include <numbers>

#include "components/devices/core/device_clock.h"

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr std::byte kLms200Start{0x02};
constexpr std::byte kAcknowledge{0x06};
constexpr std::byte kRefuse{0x15};
constexpr std::byte kAnswerOfMode{0xA0};
constexpr std::byte kMeasurement{0xB0};
constexpr std::uint8_t kFromScanner = 0x80;  // address flag of telegrams from the scanner

constexpr std::uint32_t kRateAtPowerOn = 9600;
constexpr int kLms200Attempts = 3;
constexpr Duration kAcknowledgeTime = 60ms;
constexpr Duration kLms200AnswerTime = 1s;
constexpr Duration kAnswerTimeInterlaced = 3s;
constexpr Duration kPause = 30ms;
constexpr double kLms200TurnMilliseconds = 1000.0 / 75;  // one turn of the mirror

constexpr std::byte operator""_b(unsigned long long value) { return static_cast<std::byte>(value); }

std::byte rate_code(std::uint32_t baud) {
  switch (baud) {
    case 19200:
      return 0x41_b;
    case 38400:
      return 0x40_b;
    case 500000:
      return 0x48_b;
    default:
      return 0x42_b;
  }
}

// Field of view and step, deg, determined by the number of values. The mirror measures one value a
// degree: scans with a step of a half or a quarter degree are put together from two or four turns,
// each shifted by the step.
struct AngularField {
  std::size_t values;
  int angle;
  double step;
  int turns;

  // From the first value to the last one, ms, in whole milliseconds as the original counts.
  [[nodiscard]] u32 duration() const {
    return static_cast<u32>(kLms200TurnMilliseconds * ((turns - 1) * 360 + angle) / 360);
  }
};
constexpr std::array<AngularField, 7> kAngularFields = {{{181, 180, 1.0, 1},
                                                         {361, 180, 0.5, 2},
                                                         {401, 100, 0.25, 4},
                                                         {101, 100, 1.0, 1},
                                                         {201, 100, 0.5, 2},
                                                         {100, 100, 1.0, 1},
                                                         {180, 180, 1.0, 1}}};

const AngularField* field_of(std::size_t values) {
  for (const AngularField& field : kAngularFields)
    if (field.values == values) return &field;
  return nullptr;
}

float radians(double degrees) { return static_cast<float>(degrees * std::numbers::pi / 180); }

}  // namespace

std::uint16_t lms200_crc(std::span<const std::byte> bytes) {
  constexpr unsigned kPolynomial = 0x8005;
  unsigned crc = 0;
  unsigned before = 0;
  for (const std::byte byte : bytes) {
    const auto current = std::to_integer<unsigned>(byte);
    const bool carry = (crc & 0x8000) != 0;
    crc = (crc << 1) & 0xFFFF;
    if (carry) crc ^= kPolynomial;
    crc ^= current | before << 8;
    before = current;
  }
  return static_cast<std::uint16_t>(crc);
}

void append_lms200(std::vector<std::byte>& out, std::span<const std::byte> body,
                   std::uint8_t address) {
  const std::size_t begin = out.size();
  out.push_back(kLms200Start);
  out.push_back(static_cast<std::byte>(address));
  out.push_back(static_cast<std::byte>(body.size()));
  out.push_back(static_cast<std::byte>(body.size() >> 8));
  out.insert(out.end(), body.begin(), body.end());
  const std::uint16_t crc = lms200_crc(std::span(out).subspan(begin));
  out.push_back(static_cast<std::byte>(crc));
  out.push_back(static_cast<std::byte>(crc >> 8));
}

// Skips noise byte by byte.
Lms200Telegrams::What Lms200Telegrams::next(Lms200Telegram& telegram) {
  buffer_.consume(std::exchange(used_, 0));
  while (buffer_.size() > 0) {
    const auto bytes = buffer_.bytes();
    if (bytes.front() == kAcknowledge || bytes.front() == kRefuse) {
      const bool good = bytes.front() == kAcknowledge;
      used_ = 1;
      return good ? What::kAcknowledged : What::kRefused;
    }
    if (bytes.front() != kLms200Start) {
      buffer_.consume(1);
      continue;
    }
    if (bytes.size() < 4) return What::kNothing;
    const std::size_t size = little_endian<std::uint16_t>(bytes, 2);
    if (size == 0 || size > kBodyMax) {
      buffer_.consume(1);
      continue;
    }
    if (bytes.size() < size + kFrame) return What::kNothing;
    const auto frame = bytes.first(size + kFrame);
    if (lms200_crc(frame.first(size + 4)) != little_endian<std::uint16_t>(frame, size + 4)) {
      ++broken_;
      buffer_.consume(1);
      continue;
    }
    telegram = {.address = std::to_integer<std::uint8_t>(frame[1]),
                .body = frame.subspan(4, size),
                .began = buffer_.time_of(0)};
    used_ = frame.size();
    return What::kTelegram;
  }
  return What::kNothing;
}

bool decode_lms200_scan(std::span<const std::byte> body, LadarData& scan) {
  constexpr std::size_t kHead = 3;
  if (body.size() < kHead || body.front() != kMeasurement) return false;
  const unsigned count_and_flags = little_endian<std::uint16_t>(body, 1);
  const std::size_t values = count_and_flags & 0x3FF;
  const AngularField* const field = field_of(values);
  if (field == nullptr || body.size() < kHead + 2 * values) return false;

  // With unit cm the upper three bits are flags, with mm only the highest one.
  const bool in_millimetres = count_and_flags >> 14 != 0;
  const unsigned mask = in_millimetres ? 0x7FFF : 0x1FFF;
  const int scale = in_millimetres ? 1 : 10;
  const double quarter = 0.25 * (count_and_flags >> 11 & 3);
  const double half = field->angle / 2.0;
  const double first = half - quarter;  // the scanner sends counterclockwise, so this is the last

  scan.maxRange = static_cast<i32>(mask) * scale;
  scan.duration = field->duration();
  scan.endAngle = radians(first);
  scan.startAngle = radians(first - static_cast<double>(values - 1) * field->step);
  scan.points.resize(values);
  for (std::size_t i = 0; i < values; ++i) {
    const unsigned value = little_endian<std::uint16_t>(body, kHead + 2 * i);
    const auto distance = static_cast<i32>(value & mask);
    // The highest values are codes, for example dazzled or out of range.
    const bool is_measured = distance > 0 && distance < static_cast<i32>(mask) - 8;
    const bool is_reflector = is_measured && (value & ~mask) != 0;
    LadarPoint& point = scan.points[values - 1 - i];
    point.angle = radians(first - static_cast<double>(i) * field->step);
    point.distance = distance * scale;
    point.type = !is_measured   ? ladar_point::kInvalid
                 : is_reflector ? ladar_point::kReflector
                                : ladar_point::kUnknown;
    point.intensity = is_reflector ? 1 : 0;
  }
  return true;
}

void Lms200::start(Time now, Output& out) {
  clear_failure();
  telegrams_.clear();
  has_scan_ = false;
  recorded_ = {};
  clock_.reset();
  if (settings_.only_listen) {
    state_ = State::kMeasuring;
    timer_.reset();
    return;
  }
  rate_ = kRateAtPowerOn;
  out.set_baud(rate_);
  enter(State::kLogin, now, out);
}

void Lms200::stop(Time, Output& out) {
  if (settings_.only_listen || state_ != State::kMeasuring) return;
  // Stops continuous output and restores the rate of power-on, so that the next program finds the
  // scanner.
  constexpr std::array kQuiet = {0x20_b, 0x25_b};
  constexpr std::array kSlow = {0x20_b, 0x42_b};
  question_.clear();
  append_lms200(question_, kQuiet);
  append_lms200(question_, kSlow);
  out.send(question_);
}

void Lms200::enter(State state, Time now, Output& out) {
  state_ = state;
  refused_ = false;
  timer_.reset();
  if (state != State::kMeasuring) ask(now, out);
}

void Lms200::ask(Time now, Output& out) {
  constexpr std::array kLogin = {0x20_b, 0x00_b, 0x53_b, 0x49_b, 0x43_b,
                                 0x4B_b, 0x5F_b, 0x4C_b, 0x4D_b, 0x53_b};  // "SICK_LMS"
  const bool is_raw = settings_.mode != Lms200Mode::kNormal;
  const std::array rate = {0x20_b, rate_code(settings_.baud)};
  const std::array start = {0x20_b, is_raw ? 0x2A_b : 0x24_b};
  question_.clear();
  if (state_ == State::kLogin) append_lms200(question_, kLogin);
  if (state_ == State::kRate) append_lms200(question_, rate);
  if (state_ == State::kStart) append_lms200(question_, start);
  acknowledged_ = pausing_ = false;
  out.send(question_);
  timer_.sent(now, kAcknowledgeTime + line_time(question_.size(), rate_));
}

void Lms200::on_arrival(const Arrival& arrival, Output& out) {
  using What = Lms200Telegrams::What;
  telegrams_.add(arrival);
  Lms200Telegram telegram;
  for (What what = telegrams_.next(telegram); what != What::kNothing;
       what = telegrams_.next(telegram)) {
    const bool waits = state_ != State::kMeasuring && !pausing_;
    if (what == What::kTelegram && !telegram.body.empty() && telegram.body[0] == kMeasurement) {
      take_scan(telegram);
    } else if (what == What::kAcknowledged && waits && !acknowledged_) {
      acknowledged_ = true;
      const bool is_slow = settings_.mode == Lms200Mode::kInterlaced;
      timer_.wait_until(arrival.last + (is_slow ? kAnswerTimeInterlaced : kLms200AnswerTime));
    } else if (what == What::kRefused && waits) {
      // At the wrong rate, 15 may be a garbled byte.
      refused_ = state_ != State::kLogin;
      retry(arrival.last, out);
    } else if (what == What::kTelegram && waits && telegram.body.size() >= 2 &&
               (telegram.address & kFromScanner) != 0 && telegram.body[0] == kAnswerOfMode) {
      refused_ = telegram.body[1] != 0x00_b;
      if (refused_)
        retry(arrival.last, out);
      else
        on_answer(arrival.last, out);
    }
  }
}

// The scanner needs a pause before the next request.
void Lms200::on_answer(Time now, Output& out) {
  if (state_ == State::kRate) {
    rate_ = settings_.baud;
    out.set_baud(rate_);
  }
  pausing_ = true;
  timer_.wait_until(now + kPause);
}

void Lms200::on_timeout(Time now, Output& out) {
  if (!timer_.take_due(now)) return;
  if (!pausing_) {
    retry(now, out);
    return;
  }
  const bool has_rate = rate_ == settings_.baud;
  enter(state_ == State::kLogin  ? (has_rate ? State::kStart : State::kRate)
        : state_ == State::kRate ? State::kStart
                                 : State::kMeasuring,
        now, out);
}

// Tries the rate of power-on first, then the requested one, which may have been set before: by
// another program, or by this one if the answer was lost.
void Lms200::retry(Time now, Output& out) {
  if (timer_.may_repeat(kLms200Attempts)) return ask(now, out);
  if (state_ <= State::kRate && !refused_ && rate_ != settings_.baud)
    return log_in_at_wanted_rate(now, out);
  fail(tims::Errc::kTimeout,
       state_ == State::kLogin && !refused_
           ? "the scanner answers neither at 9600 nor at " + std::to_string(settings_.baud) +
                 " baud; check its power and the serial line (RS-422 for 500000)"
           : "the scanner refuses " + std::to_string(settings_.baud) + " baud or this mode");
}

void Lms200::log_in_at_wanted_rate(Time now, Output& out) {
  rate_ = settings_.baud;
  out.set_baud(rate_);
  telegrams_.clear();
  enter(State::kLogin, now, out);
}

void Lms200::take_scan(const Lms200Telegram& telegram) {
  if (!decode_lms200_scan(telegram.body, scan_)) return;
  has_scan_ = true;
  // The telegram is sent at the end of the scan; its middle was half a scan before.
  recorded_ = clock_.to_host(telegram.began) - std::chrono::milliseconds(scan_.duration) / 2;
}

bool Lms200::take(LadarData& scan, Time& recorded) {
  if (!std::exchange(has_scan_, false)) return false;
  std::swap(scan, scan_);
  recorded = recorded_;
  return true;
}

}  // namespace rack::device
