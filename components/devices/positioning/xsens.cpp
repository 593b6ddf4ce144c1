#include "components/devices/positioning/xsens.h"

#include <bit>
#include <cmath>
#include <numbers>

#include "base/text.h"
#include "rack/devices/pieces.h"

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr std::byte kPreamble{0xFA};
constexpr std::byte kMaster{0xFF};
constexpr std::byte kLongLength{0xFF};
constexpr int kXsensAttempts = 3;
constexpr Duration kXsensAnswerTime = 500ms;
constexpr double kXsensDegree = std::numbers::pi / 180;
constexpr double kTicksOfSecond = 115200;  // unit of the period of MTData, 1/s
constexpr double kMost = 1e6;              // limit for plausible values in SI units or degrees

using Vector = XsensSample::Vector;
using Rotation = XsensSample::Rotation;

unsigned sum_of(std::span<const std::byte> bytes) {
  unsigned sum = 0;
  for (const std::byte byte : bytes) sum += std::to_integer<unsigned>(byte);
  return sum & 0xFF;
}

double float_at(std::span<const std::byte> bytes, std::size_t at) {
  return static_cast<double>(std::bit_cast<float>(big_endian<std::uint32_t>(bytes, at)));
}
double double_at(std::span<const std::byte> bytes, std::size_t at) {
  return std::bit_cast<double>(big_endian<std::uint64_t>(bytes, at));
}
// Fixed-point number: 32 bits of the fraction are followed by 16 bits of the integer.
double long_fixed_at(std::span<const std::byte> bytes, std::size_t at) {
  return big_endian<std::int16_t>(bytes, at + 4) +
         big_endian<std::uint32_t>(bytes, at) / 4294967296.0;
}

// Reads numbers in the format given by the lower two bits of an item.
bool numbers_of(std::uint16_t item, std::span<const std::byte> bytes, std::span<double> numbers) {
  constexpr std::array<std::size_t, 4> kSizes = {4, 4, 6, 8};
  const unsigned format = item & 3U;
  const std::size_t size = kSizes[format];
  if (bytes.size() != size * numbers.size()) return false;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::size_t at = i * size;
    numbers[i] = format == 0   ? float_at(bytes, at)
                 : format == 1 ? big_endian<std::int32_t>(bytes, at) / 1048576.0
                 : format == 2 ? long_fixed_at(bytes, at)
                               : double_at(bytes, at);
    // Also rejects NaN and numbers that exceed the range of float.
    if (!(std::abs(numbers[i]) <= kMost)) return false;
  }
  return true;
}

std::optional<Vector> vector_of(std::uint16_t item, std::span<const std::byte> bytes,
                                double scale = 1) {
  std::array<double, 3> numbers{};
  if (!numbers_of(item, bytes, numbers)) return std::nullopt;
  return Vector{numbers[0] * scale, numbers[1] * scale, numbers[2] * scale};
}

std::optional<Rotation> rotation_of(std::uint16_t item, std::span<const std::byte> bytes) {
  std::array<double, 4> numbers{};
  if (!numbers_of(item, bytes, numbers)) return std::nullopt;
  return Rotation{numbers[0], numbers[1], numbers[2], numbers[3]};
}

Rotation operator*(const Rotation& a, const Rotation& b) {
  return {.w = a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
          .x = a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          .y = a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          .z = a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

// Rotation order: yaw about z, pitch about y, roll about x.
Rotation from_euler(const Vector& euler) {
  const auto about = [](double angle) {
    return std::pair(std::cos(angle / 2), std::sin(angle / 2));
  };
  const auto [roll_w, roll_x] = about(euler.x);
  const auto [pitch_w, pitch_y] = about(euler.y);
  const auto [yaw_w, yaw_z] = about(euler.z);
  return Rotation{yaw_w, 0, 0, yaw_z} * Rotation{pitch_w, 0, pitch_y, 0} *
         Rotation{roll_w, roll_x, 0, 0};
}

Vector to_euler(const Rotation& q) {
  const double sine = std::clamp(2 * (q.w * q.y - q.x * q.z), -1.0, 1.0);
  return {.x = std::atan2(2 * (q.w * q.x + q.y * q.z), 1 - 2 * (q.x * q.x + q.y * q.y)),
          .y = std::asin(sine),
          .z = std::atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))};
}

// Half a turn about x: z up becomes z down.
constexpr Rotation kHalfTurn{0, 1, 0, 0};

// Rotation from the Earth frame of the device to north, east, down.
Rotation to_north_east_down(std::uint16_t frame) {
  constexpr double kHalf = std::numbers::sqrt2 / 2;
  if (frame == xsens::kNorthEastDown) return {};
  if (frame == xsens::kNorthWestUp) return kHalfTurn;
  return {0, kHalf, kHalf, 0};  // swaps x and y and inverts z
}

bool decode_data(std::span<const std::byte> data, XsensSample& sample) {
  constexpr std::size_t kCalibrated = 36;  // accelerations, rates, magnetic field
  constexpr std::size_t kWithEuler = kCalibrated + 12;
  constexpr std::size_t kWithQuaternion = kCalibrated + 16;
  constexpr std::size_t kCounter = 2;
  const bool has_counter =
      data.size() == kWithEuler + kCounter || data.size() == kWithQuaternion + kCounter;
  const std::size_t size = has_counter ? data.size() - kCounter : data.size();
  if (size != kWithEuler && size != kWithQuaternion) return false;
  sample.acceleration = vector_of(0, data.first(12));
  sample.rate = vector_of(0, data.subspan(12, 12));
  if (size == kWithEuler)
    sample.euler = vector_of(0, data.subspan(kCalibrated, 12), kXsensDegree);
  else
    sample.orientation = rotation_of(0, data.subspan(kCalibrated, 16));
  if (has_counter) sample.counter = big_endian<std::uint16_t>(data, size);
  return true;
}

void decode_item(std::uint16_t item, std::span<const std::byte> bytes, XsensSample& sample) {
  const auto kind = static_cast<std::uint16_t>(item & ~0xFU);
  const auto frame = static_cast<std::uint16_t>(item & xsens::kFrameMask);
  if (kind == xsens::kAcceleration) sample.acceleration = vector_of(item, bytes);
  if (kind == xsens::kRateOfTurn) sample.rate = vector_of(item, bytes);
  if (kind == xsens::kSampleTime && bytes.size() == 4)
    sample.counter = big_endian<std::uint32_t>(bytes);
  if (kind == xsens::kQuaternion) sample.orientation = rotation_of(item, bytes);
  if (kind == xsens::kEuler) sample.euler = vector_of(item, bytes, kXsensDegree);
  if (kind == xsens::kQuaternion || kind == xsens::kEuler) sample.frame = frame;
}

bool decode_data2(std::span<const std::byte> data, XsensSample& sample) {
  constexpr std::size_t kHead = 3;
  while (data.size() >= kHead) {
    const std::size_t size = std::to_integer<std::size_t>(data[2]);
    if (data.size() < kHead + size) return false;
    decode_item(big_endian<std::uint16_t>(data), data.subspan(kHead, size), sample);
    data = data.subspan(kHead + size);
  }
  return data.empty();
}

}  // namespace

void append_xsens(std::vector<std::byte>& out, std::uint8_t number,
                  std::span<const std::byte> data) {
  constexpr std::size_t kShortMax = 0xFE;
  out.push_back(kPreamble);
  const std::size_t begin = out.size();
  out.push_back(kMaster);
  out.push_back(static_cast<std::byte>(number));
  if (data.size() > kShortMax) {
    out.push_back(kLongLength);
    append_big(out, static_cast<std::uint16_t>(data.size()));
  } else {
    out.push_back(static_cast<std::byte>(data.size()));
  }
  out.insert(out.end(), data.begin(), data.end());
  out.push_back(static_cast<std::byte>(0x100 - sum_of(std::span(out).subspan(begin))));
}

void XsensMessages::clear() {
  buffer_.clear();
  used_ = 0;
}

bool XsensMessages::next(XsensMessage& message) {
  buffer_.consume(std::exchange(used_, 0));
  for (; buffer_.size() > 0; buffer_.consume(1)) {
    auto bytes = buffer_.bytes();
    std::size_t skipped = 0;
    while (skipped < bytes.size() && bytes[skipped] != kPreamble) ++skipped;
    buffer_.consume(skipped);
    bytes = bytes.subspan(skipped);
    if (bytes.size() < 2) return false;
    if (bytes[1] != kMaster) continue;
    if (bytes.size() < 4) return false;
    const bool is_long = bytes[3] == kLongLength;
    const std::size_t head = is_long ? 6 : 4;
    if (bytes.size() < head) return false;
    const std::size_t size =
        is_long ? big_endian<std::uint16_t>(bytes, 4) : std::to_integer<std::size_t>(bytes[3]);
    if (size > kDataMax) continue;
    if (bytes.size() < head + size + 1) return false;
    if (sum_of(bytes.subspan(1, head + size)) != 0) {
      ++broken_;
      continue;
    }
    used_ = head + size + 1;
    message = {.number = std::to_integer<std::uint8_t>(bytes[2]),
               .data = bytes.subspan(head, size),
               .began = buffer_.time_of(0)};
    return true;
  }
  return false;
}

bool decode_xsens(const XsensMessage& message, XsensSample& sample) {
  sample.acceleration.reset();
  sample.rate.reset();
  sample.orientation.reset();
  sample.euler.reset();
  sample.counter.reset();
  sample.frame = xsens::kNorthWestUp;
  if (message.number == xsens::kData) return decode_data(message.data, sample);
  return message.number == xsens::kData2 && decode_data2(message.data, sample);
}

bool to_gyro(const XsensSample& sample, XsensMounting mounting, GyroData& data) {
  const bool has_orientation = sample.orientation || sample.euler;
  if (!sample.acceleration || !sample.rate || !has_orientation) return false;
  // With the label up, y of the device is to the left and z is up.
  const double side = mounting == XsensMounting::kLabelUp ? -1 : 1;
  constexpr double kMillimetres = -1000;
  data.aX = static_cast<f32>(sample.acceleration->x * kMillimetres);
  data.aY = static_cast<f32>(sample.acceleration->y * side * kMillimetres);
  data.aZ = static_cast<f32>(sample.acceleration->z * side * kMillimetres);
  data.wRoll = static_cast<f32>(sample.rate->x);
  data.wPitch = static_cast<f32>(sample.rate->y * side);
  data.wYaw = static_cast<f32>(sample.rate->z * side);

  Vector euler = sample.euler.value_or(Vector{});
  const bool is_unchanged = mounting == XsensMounting::kUnchanged;
  if (sample.orientation || !is_unchanged) {
    Rotation rotation = sample.orientation ? *sample.orientation : from_euler(euler);
    if (!is_unchanged) rotation = to_north_east_down(sample.frame) * rotation;
    if (mounting == XsensMounting::kLabelUp) rotation = rotation * kHalfTurn;
    euler = to_euler(rotation);
  }
  data.roll = static_cast<f32>(euler.x);
  data.pitch = static_cast<f32>(euler.y);
  data.yaw = static_cast<f32>(euler.z);
  return true;
}

// --- the dialogue

void Xsens::start(Time now, Output& out) {
  clear_failure();
  messages_.clear();
  clock_.reset();
  sends_data_ = has_data_ = false;
  serial_number_.clear();
  if (settings_.only_listen) {
    state_ = State::kMeasuring;
    timer_.reset();
    return;
  }
  enter(State::kConfiguration, now, out);
}

void Xsens::enter(State state, Time now, Output& out) {
  state_ = state;
  timer_.reset();
  if (state != State::kMeasuring) ask(now, out);
}

void Xsens::ask(Time now, Output& out) {
  constexpr std::uint16_t kAlways = 0xFFFF;
  constexpr std::uint16_t kCalibratedAndOrientation = 0x0006;
  constexpr std::uint32_t kCounterAndEuler = 0x00000005;
  const auto rate = static_cast<std::uint16_t>(Duration(1s) / settings_.period);
  body_.clear();
  switch (state_) {
    case State::kConfiguration:
      asked_ = xsens::kToConfiguration;
      break;
    case State::kIdentity:
      asked_ = xsens::kAskIdentity;
      break;
    case State::kOutput:
      asked_ = xsens::kSetOutput;
      for (const auto& [item, often] :
           {std::pair{xsens::kPacketCounter, kAlways},
            {xsens::kSampleTime, kAlways},
            {static_cast<std::uint16_t>(xsens::kQuaternion | xsens::kNorthWestUp), rate},
            {xsens::kAcceleration, rate},
            {xsens::kRateOfTurn, rate}}) {
        append_big(body_, item);
        append_big(body_, often);
      }
      break;
    case State::kPeriod:
      asked_ = xsens::kSetPeriod;
      append_big(body_, static_cast<std::uint16_t>(std::lround(kTicksOfSecond / rate)));
      break;
    case State::kMode:
      asked_ = xsens::kSetMode;
      append_big(body_, kCalibratedAndOrientation);
      break;
    case State::kSettings:
      asked_ = xsens::kSetSettings;
      append_big(body_, kCounterAndEuler);
      break;
    case State::kStart:
    case State::kMeasuring:
      asked_ = xsens::kToMeasurement;
      break;
  }
  question_.clear();
  append_xsens(question_, asked_, body_);
  out.send(question_);
  timer_.sent(now, kXsensAnswerTime);
}

void Xsens::on_arrival(const Arrival& arrival, Output& out) {
  in_pieces(arrival, XsensMessages::kPieceMax, [&](const Arrival& piece) {
    messages_.add(piece);
    XsensMessage message;
    while (messages_.next(message)) on_message(message, out);
  });
}

void Xsens::on_message(const XsensMessage& message, Output& out) {
  if (message.number == xsens::kData || message.number == xsens::kData2) {
    sends_data_ = true;
    if (state_ == State::kMeasuring) take_sample(message);
    return;
  }
  if (state_ == State::kMeasuring) return;
  if (message.number == asked_ + xsens::kAnswers) on_answer(message, out);
  if (message.number == xsens::kError) on_refusal(message, out);
}

// Continues with or without a device id; without one, only an unrestricted configuration accepts
// it.
void Xsens::identified(Time now, Output& out) {
  if (is_wanted("device", serial_number_, settings_.serial_number)) enter(State::kOutput, now, out);
}

void Xsens::on_answer(const XsensMessage& message, Output& out) {
  const Time now = message.began;
  switch (state_) {
    case State::kConfiguration:
      return enter(State::kIdentity, now, out);
    case State::kIdentity:
      serial_number_ = tims::base::to_hex(message.data);
      return identified(now, out);
    case State::kOutput:
    case State::kSettings:
      return enter(State::kStart, now, out);
    case State::kPeriod:
      return enter(State::kMode, now, out);
    case State::kMode:
      return enter(State::kSettings, now, out);
    case State::kStart:
    case State::kMeasuring:
      return enter(State::kMeasuring, now, out);
  }
}

// Older devices do not support MTData2.
void Xsens::on_refusal(const XsensMessage& message, Output& out) {
  if (state_ == State::kOutput) return enter(State::kPeriod, message.began, out);
  // The error message does not name its request: it may refer to a repetition of the previous one.
  if (timer_.may_repeat(kXsensAttempts)) return ask(message.began, out);
  if (state_ == State::kIdentity) return identified(message.began, out);
  const unsigned code = message.data.empty() ? 0 : std::to_integer<unsigned>(message.data.front());
  fail(tims::Errc::kSystem, "the device refuses its configuration, error " + std::to_string(code));
}

void Xsens::on_timeout(Time now, Output& out) {
  if (!timer_.take_due(now)) return;
  if (timer_.may_repeat(kXsensAttempts)) return ask(now, out);
  if (state_ == State::kIdentity) return identified(now, out);
  if (state_ == State::kOutput) return enter(State::kPeriod, now, out);
  // The device does not answer but sends data, so only the line to the host works: accept that.
  if (sends_data_ && state_ == State::kConfiguration) {
    if (is_wanted("device", serial_number_, settings_.serial_number))
      enter(State::kMeasuring, now, out);
    return;
  }
  fail(tims::Errc::kTimeout, state_ == State::kConfiguration
                                 ? "no Xsens device answers at " + std::to_string(settings_.baud) +
                                       " baud; check its power and baudrate"
                                 : "the device does not answer during its configuration");
}

void Xsens::take_sample(const XsensMessage& message) {
  XsensSample sample;
  if (!decode_xsens(message, sample) || !to_gyro(sample, settings_.mounting, data_)) return;
  recorded_ = measured_at(message, sample);
  has_data_ = true;
}

// Uses the counter of the device, which has no jitter. In a recording its rate is unknown.
Time Xsens::measured_at(const XsensMessage& message, const XsensSample& sample) {
  const bool counts_time = message.number == xsens::kData2;
  if (!sample.counter || (settings_.only_listen && !counts_time)) return message.began;
  if (!clock_ || clock_counts_time_ != counts_time) {
    if (counts_time)
      clock_.emplace(100us, std::uint64_t{1} << 32);
    else
      clock_.emplace(settings_.period, std::uint64_t{1} << 16);
    clock_counts_time_ = counts_time;
  }
  return clock_->to_host(*sample.counter, message.began);
}

bool Xsens::take(GyroData& data, Time& recorded) {
  if (!std::exchange(has_data_, false)) return false;
  data = data_;
  recorded = recorded_;
  return true;
}

}  // namespace rack::device
