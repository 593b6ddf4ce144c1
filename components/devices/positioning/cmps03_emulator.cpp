#include "components/devices/positioning/cmps03_emulator.h"

#include <array>
#include <cmath>
#include <string_view>

#include "components/devices/positioning/cmps03.h"

namespace rack::device::emulator {

void Cmps03Emulator::start(Time now, Output&) {
  is_confirming_ = false;
  directions_ = 0;
  began_ = next_ = now;
}

void Cmps03Emulator::on_arrival(const Arrival& arrival, Output& out) {
  constexpr std::string_view kGood = "$OK\n";
  for (const std::byte byte : arrival.bytes) {
    if (byte == cmps03::kCalibrate) {
      is_confirming_ = true;
      out.send(std::as_bytes(std::span(kGood)));
    } else if (byte == cmps03::kConfirm && is_confirming_) {
      is_confirming_ = false;
      ++directions_;
    }
  }
}

void Cmps03Emulator::on_timeout(Time now, Output& out) {
  if (next_ > now) return;
  const double degrees = std::fmod(heading_(next_, next_ - began_), 360);
  auto tenths = static_cast<int>((degrees < 0 ? degrees + 360 : degrees) * 10) % 3600;
  std::array<char, 6> line{'$', '0', '0', '0', '0', '\n'};
  for (std::size_t i = 4; i > 0; --i, tenths /= 10) line[i] = static_cast<char>('0' + tenths % 10);
  out.send(std::as_bytes(std::span(line)));
  next_ += kPeriod;
}

}  // namespace rack::device::emulator
