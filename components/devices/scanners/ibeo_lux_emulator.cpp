#include "components/devices/scanners/ibeo_lux_emulator.h"

#include <cmath>
#include <numbers>

namespace rack::device::emulator {
namespace {

using namespace std::chrono_literals;

constexpr int kTicks = 11520;                      // per turn
constexpr double kIbeoLuxEmulatorRange = 200'000;  // mm
constexpr int kIbeoLuxEmulatorFirst = 50 * kTicks / 360;
constexpr int kIbeoLuxEmulatorLast = -50 * kTicks / 360;
constexpr int kIbeoLuxEmulatorStep = 16;  // half a degree
constexpr int kLayers = 4;
constexpr Duration kScanTime = 22ms;
constexpr Duration kMakes = 5ms;  // from the end of a scan to its message

}  // namespace

void IbeoLux::start(Time now, Output&) {
  began_ = now;
  number_ = 0;
  before_ = 0;
  next_ = now + settings_.period;
}

std::uint64_t IbeoLux::ntp(Time time) const {
  const auto since = std::chrono::duration_cast<std::chrono::microseconds>(time - began_).count();
  const auto seconds = static_cast<std::uint64_t>(since / 1'000'000);
  const auto fraction = static_cast<std::uint64_t>(since % 1'000'000);
  return settings_.ntp + (seconds << 32) + (fraction << 32) / 1'000'000;
}

void IbeoLux::append(std::int64_t number, int bytes) {
  for (int i = 0; i < bytes; ++i) body_.push_back(static_cast<std::byte>(number >> 8 * i));
}

void IbeoLux::append_head(std::uint16_t kind, std::size_t size, Time now) {
  const auto put = [&](std::uint64_t number, int bytes) {
    for (int i = bytes - 1; i >= 0; --i)
      message_.push_back(static_cast<std::byte>(number >> 8 * i));
  };
  put(0xAFFEC0C2, 4);
  put(before_, 4);
  put(size, 4);
  put(0, 1);
  put(7, 1);
  put(kind, 2);
  put(ntp(now), 8);
  before_ = static_cast<std::uint32_t>(size + lux::kHead);
}

void IbeoLux::on_timeout(Time now, Output& out) {
  if (next_ > now) return;
  const Time end = next_ - kMakes;
  message_.clear();
  append_scan(end - kScanTime, end, next_);
  append_objects(end - kScanTime, next_);
  out.send(message_);
  next_ += settings_.period;
}

void IbeoLux::append_scan(Time begin, Time end, Time now) {
  constexpr int kPoints =
      (kIbeoLuxEmulatorFirst - kIbeoLuxEmulatorLast) / kIbeoLuxEmulatorStep * kLayers;
  body_.clear();
  append(number_++, 2);
  append(0, 4);  // status, phase
  append(static_cast<std::int64_t>(ntp(begin)), 8);
  append(static_cast<std::int64_t>(ntp(end)), 8);
  append(kTicks, 2);
  append(kIbeoLuxEmulatorFirst, 2);
  append(kIbeoLuxEmulatorLast, 2);
  append(kPoints, 2);
  append(0, 8);  // mounting position
  append(0, 6);  // flags
  for (int i = 0; i < kPoints; ++i) {
    const int tick = kIbeoLuxEmulatorFirst - i / kLayers * kIbeoLuxEmulatorStep;
    const double angle = -2 * std::numbers::pi * tick / kTicks;
    append(i % kLayers, 1);  // layer, first echo
    append(0, 1);
    append(tick, 2);
    const Time when = begin + (end - begin) * (kIbeoLuxEmulatorFirst - tick) /
                                  (kIbeoLuxEmulatorFirst - kIbeoLuxEmulatorLast);
    const double distance = settings_.sight(angle, 0, when);
    append(distance > kIbeoLuxEmulatorRange ? 0 : std::lround(distance / 10), 2);
    append(30, 2);
    append(0, 2);
  }
  append_head(lux::kScan, body_.size(), now);
  message_.insert(message_.end(), body_.begin(), body_.end());
}

void IbeoLux::append_objects(Time begin, Time now) {
  body_.clear();
  append(static_cast<std::int64_t>(ntp(begin)), 8);
  append(1, 2);
  append(17, 2);   // object id
  append(100, 2);  // age
  append(0, 4);
  for (const int number : {1000,    150, 8,   9,  // centre and its standard deviation, cm
                           900,     120,          // nearest point
                           1000,    150, 460, 190, 1000, 150, 450, 180,
                           -5 * 32,  // rotated to the right
                           -300,    20,  11,  12,  -400, 25,  5,   60,  90})
    append(number, 2);
  append(settings_.has_contour_fault ? 0xFFFF : 3, 2);
  if (!settings_.has_contour_fault)
    for (const int number : {900, 60, 900, 240, 1300, 240}) append(number, 2);
  append_head(lux::kObjects, body_.size(), now);
  message_.insert(message_.end(), body_.begin(), body_.end());
}

}  // namespace rack::device::emulator
