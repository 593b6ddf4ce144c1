#include "components/devices/scanners/ld19_emulator.h"

#include <cmath>
#include <numbers>

namespace rack::device::emulator {
namespace {

std::uint32_t hundredths(double degrees) {
  return static_cast<std::uint32_t>(std::lround(100 * std::fmod(degrees, 360))) % 36'000;
}

}  // namespace

void Ld19::start(Time now, Output& out) {
  constexpr std::uint32_t kBaud = 230400;
  out.set_baud(kBaud);
  began_ = now;
  point_ = 0;
  next_ = now + packet_time();
}

Duration Ld19::packet_time() const {
  return Duration(std::chrono::seconds(1)) * static_cast<std::int64_t>(kLd19Points) /
         settings_.points_a_second;
}

double Ld19::angle_of(std::uint64_t point) const {
  return 360.0 * settings_.turns_a_second * static_cast<double>(point) / settings_.points_a_second;
}

void Ld19::on_timeout(Time now, Output& out) {
  if (next_ > now) return;
  constexpr std::uint32_t kIntensity = 200;
  constexpr std::uint32_t kTimeEnd = 30'000;
  constexpr double kRange = 12'000;
  const auto since = std::chrono::duration_cast<std::chrono::milliseconds>(next_ - began_).count();
  packet_.clear();
  append_little(packet_, 0x2C54, 2);
  append_little(packet_, static_cast<std::uint32_t>(360 * settings_.turns_a_second), 2);
  append_little(packet_, hundredths(angle_of(point_)), 2);
  for (std::uint64_t i = 0; i < kLd19Points; ++i) {
    const double angle = angle_of(point_ + i) * std::numbers::pi / 180;
    const Time when = next_ - packet_time() * static_cast<std::int64_t>(kLd19Points - i) /
                                  static_cast<std::int64_t>(kLd19Points);
    const double distance = settings_.sight(angle, 0, when);
    append_little(packet_,
                  distance > kRange ? 0 : static_cast<std::uint32_t>(std::lround(distance)), 2);
    append_little(packet_, kIntensity, 1);
  }
  append_little(packet_, hundredths(angle_of(point_ + kLd19Points - 1)), 2);
  append_little(packet_, static_cast<std::uint32_t>(since) % kTimeEnd, 2);
  append_little(packet_, ld19_crc(packet_), 1);
  out.send(packet_);
  point_ += kLd19Points;
  next_ += packet_time();
}

}  // namespace rack::device::emulator
