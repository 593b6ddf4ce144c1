#include "components/devices/positioning/xsens_emulator.h"

#include <bit>
#include <cmath>
#include <numbers>

#include "rack/devices/pieces.h"

namespace rack::device::emulator {
namespace {

using namespace std::chrono_literals;

constexpr double kGravity = 9.81;
constexpr Duration kTick = 100us;

template <typename Number>
void put(std::vector<std::byte>& out, Number number) {
  for (std::size_t i = sizeof(Number); i-- > 0;)
    out.push_back(static_cast<std::byte>(number >> (8 * i)));
}
void put_float(std::vector<std::byte>& out, double number) {
  put(out, std::bit_cast<std::uint32_t>(static_cast<float>(number)));
}

// Yaw, then pitch, then roll.
std::array<double, 4> quaternion(const Motion& motion) {
  const double cr = std::cos(motion.roll / 2);
  const double sr = std::sin(motion.roll / 2);
  const double cp = std::cos(motion.pitch / 2);
  const double sp = std::sin(motion.pitch / 2);
  const double cy = std::cos(motion.yaw / 2);
  const double sy = std::sin(motion.yaw / 2);
  return {cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy,
          cr * cp * sy - sr * sp * cy};
}

}  // namespace

Motion Swaying::operator()(Time /*when*/, Duration since_start) const {
  constexpr double kSways = 2 * std::numbers::pi * 0.5;  // 1/s
  const double seconds = std::chrono::duration<double>(since_start).count();
  const double roll = sway * std::sin(kSways * seconds);
  return {.roll = roll,
          .yaw = std::remainder(turn * seconds, 2 * std::numbers::pi),
          .rates = {sway * kSways * std::cos(kSways * seconds), 0, turn},
          .accelerations = {0, kGravity * std::sin(roll), kGravity * std::cos(roll)}};
}

void XsensEmulator::start(Time now, Output&) {
  messages_.clear();
  period_ = 10ms;
  began_ = now;
  next_ = now + period_;  // measures after power-on
  counter_ = 0;
}

void XsensEmulator::on_arrival(const Arrival& arrival, Output& out) {
  in_pieces(arrival, XsensMessages::kPieceMax, [&](const Arrival& piece) {
    messages_.add(piece);
    XsensMessage message;
    while (messages_.next(message)) on_message(message, piece.last, out);
  });
}

void XsensEmulator::on_message(const XsensMessage& message, Time now, Output& out) {
  answer_.clear();
  const auto answer = static_cast<std::uint8_t>(message.number + xsens::kAnswers);
  if (message.number == xsens::kToConfiguration) {
    next_ = tims::kNever;
    append_xsens(answer_, answer);
  } else if (message.number == xsens::kToMeasurement) {
    next_ = now + period_;
    append_xsens(answer_, answer);
  } else if (message.number == xsens::kAskIdentity && !is_measuring()) {
    body_.clear();
    put(body_, settings_.id);
    append_xsens(answer_, answer, body_);
  } else if (!is_measuring() && configure(message)) {
    append_xsens(answer_, answer,
                 message.number == xsens::kSetOutput ? message.data : std::span<const std::byte>{});
  } else {
    constexpr std::array kNotKnown = {std::byte{0x04}};
    append_xsens(answer_, xsens::kError, kNotKnown);
  }
  out.send(answer_);
}

bool XsensEmulator::configure(const XsensMessage& message) {
  constexpr std::size_t kItem = 4;
  switch (message.number) {
    case xsens::kSetOutput: {
      if (settings_.is_old || message.data.size() < kItem || message.data.size() % kItem != 0)
        return false;
      const auto rate = big_endian<std::uint16_t>(message.data, message.data.size() - 2);
      if (rate == 0 || rate > 400) return false;
      period_ = Duration(1s) / rate;
      return true;
    }
    case xsens::kSetPeriod:
      return settings_.is_old && message.data.size() == 2;
    case xsens::kSetMode:
      return settings_.is_old && message.data.size() == 2 &&
             big_endian<std::uint16_t>(message.data) == 6;
    case xsens::kSetSettings:
      return settings_.is_old && message.data.size() == 4 &&
             big_endian<std::uint32_t>(message.data) == 5;
    default:
      return false;
  }
}

void XsensEmulator::on_timeout(Time now, Output& out) {
  if (next_ > now) return;
  const Motion motion = settings_.inertia(next_, next_ - began_);
  body_.clear();
  answer_.clear();
  if (settings_.is_old)
    append_data(motion);
  else
    append_data2(motion);
  append_xsens(answer_, settings_.is_old ? xsens::kData : xsens::kData2, body_);
  out.send(answer_);
  ++counter_;
  next_ += period_;
}

void XsensEmulator::append_data(const Motion& motion) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  constexpr std::array kMagneticField = {0.4, 0.0, -0.8};
  for (const double number : motion.accelerations) put_float(body_, number);
  for (const double number : motion.rates) put_float(body_, number);
  for (const double number : kMagneticField) put_float(body_, number);
  for (const double angle : {motion.roll, motion.pitch, motion.yaw})
    put_float(body_, angle * kDegrees);
  put(body_, counter_);
}

void XsensEmulator::append_data2(const Motion& motion) {
  const auto item = [this](std::uint16_t id, std::span<const double> numbers) {
    put(body_, id);
    put(body_, static_cast<std::uint8_t>(numbers.size() * sizeof(float)));
    for (const double number : numbers) put_float(body_, number);
  };
  put(body_, xsens::kPacketCounter);
  put(body_, std::uint8_t{2});
  put(body_, counter_);
  put(body_, xsens::kSampleTime);
  put(body_, std::uint8_t{4});
  put(body_, static_cast<std::uint32_t>((next_ - began_) / kTick));
  item(xsens::kQuaternion | xsens::kNorthWestUp, quaternion(motion));
  item(xsens::kAcceleration, motion.accelerations);
  item(xsens::kRateOfTurn, motion.rates);
}

}  // namespace rack::device::emulator
