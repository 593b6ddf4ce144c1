#include "devices/navigation/xsens_emulator.h"

#include <bit>
#include <cmath>
#include <numbers>

#include "devices/core/pieces.h"

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

struct Motion {
  double roll = 0;
  double yaw = 0;
  double roll_rate = 0;
  double yaw_rate = 0;
};

Motion motion_at(const XsensEmulatorSettings& settings, double seconds) {
  constexpr double kSways = 2 * std::numbers::pi * 0.5;  // 1/s
  return {.roll = settings.sway * std::sin(kSways * seconds),
          .yaw = std::remainder(settings.turn * seconds, 2 * std::numbers::pi),
          .roll_rate = settings.sway * kSways * std::cos(kSways * seconds),
          .yaw_rate = settings.turn};
}

}  // namespace

void XsensEmulator::start(Time now, Output&) {
  messages_.clear();
  period_ = 10ms;
  began_ = now;
  next_ = now + period_;  // it measures when it is switched on
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
  const double seconds = std::chrono::duration<double>(next_ - began_).count();
  body_.clear();
  answer_.clear();
  if (settings_.is_old)
    append_data(seconds);
  else
    append_data2(seconds);
  append_xsens(answer_, settings_.is_old ? xsens::kData : xsens::kData2, body_);
  out.send(answer_);
  ++counter_;
  next_ += period_;
}

void XsensEmulator::append_data(double seconds) {
  const Motion motion = motion_at(settings_, seconds);
  constexpr double kDegrees = 180 / std::numbers::pi;
  for (const double number :
       {0.0, kGravity * std::sin(motion.roll), kGravity * std::cos(motion.roll), motion.roll_rate,
        0.0, motion.yaw_rate, 0.4, 0.0, -0.8, motion.roll * kDegrees, 0.0, motion.yaw * kDegrees})
    put_float(body_, number);
  put(body_, counter_);
}

void XsensEmulator::append_data2(double seconds) {
  const Motion motion = motion_at(settings_, seconds);
  const auto item = [this](std::uint16_t id, std::initializer_list<double> numbers) {
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
  const double roll = motion.roll / 2;
  const double yaw = motion.yaw / 2;
  item(xsens::kQuaternion | xsens::kNorthWestUp,
       {std::cos(yaw) * std::cos(roll), std::cos(yaw) * std::sin(roll),
        std::sin(yaw) * std::sin(roll), std::sin(yaw) * std::cos(roll)});
  item(xsens::kAcceleration,
       {0, kGravity * std::sin(motion.roll), kGravity * std::cos(motion.roll)});
  item(xsens::kRateOfTurn, {motion.roll_rate, 0, motion.yaw_rate});
}

}  // namespace rack::device::emulator
