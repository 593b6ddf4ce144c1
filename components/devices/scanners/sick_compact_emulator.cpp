#include "components/devices/scanners/sick_compact_emulator.h"

#include <bit>
#include <cmath>
#include <numbers>

namespace rack::device::emulator {
namespace {

constexpr double kRadian = std::numbers::pi / 180;

template <typename Number>
void append_little(std::vector<std::byte>& out, Number number) {
  for (std::size_t i = 0; i < sizeof(Number); ++i)
    out.push_back(static_cast<std::byte>(number >> 8 * i));
}
void append_float(std::vector<std::byte>& out, double number) {
  append_little(out, std::bit_cast<std::uint32_t>(static_cast<float>(number)));
}

// Appends a beam with remission 1000 and an azimuth; the only flag is that of reflectors.
void append_beam(std::vector<std::byte>& out, const SickCompactEmulatorSettings& settings,
                 double azimuth, double elevation, Time when) {
  constexpr double kRange = 65535;
  const double seen =
      settings.sight(-azimuth, elevation, when) / static_cast<double>(settings.factor);
  const double distance = seen > kRange ? 0 : seen;
  for (int echo = 0; echo < settings.echoes; ++echo) {
    append_little(out, static_cast<std::uint16_t>(echo == 0 ? std::lround(distance) : 0));
    append_little(out, static_cast<std::uint16_t>(1000));
  }
  const auto units = static_cast<std::uint16_t>(std::lround(azimuth * 5215) + 16384);
  if (settings.version < 4) append_little(out, units);
  out.push_back(std::byte{0});
  if (settings.version >= 4) append_little(out, units);
}

}  // namespace

void append_compact(std::vector<std::byte>& out, const SickCompactEmulatorSettings& settings,
                    std::uint64_t frame, int number, std::uint64_t started,
                    std::uint64_t transmitted) {
  const auto layers = static_cast<std::uint32_t>(settings.elevations.size());
  const double width = (settings.last - settings.first) / settings.segments;
  const double step = width / settings.beams;
  const double first = (settings.first + width * number) * kRadian;
  const double last = first + (width - step) * kRadian;
  const auto micros = static_cast<std::uint64_t>(settings.turn.count() / 1000);
  const std::uint64_t took = micros / static_cast<std::uint64_t>(settings.segments);
  const std::uint64_t begin = started + took * static_cast<std::uint64_t>(number);

  const std::size_t at = out.size();
  append_little(out, std::uint32_t{0x02020202});
  append_little(out, std::uint32_t{1});
  append_little(out, frame * static_cast<std::uint64_t>(settings.segments) +
                         static_cast<std::uint64_t>(number) + 1);
  append_little(out, transmitted);
  append_little(out, settings.version);
  const std::size_t size_at = out.size();
  append_little(out, std::uint32_t{0});
  const std::size_t module_at = out.size();
  append_little(out, static_cast<std::uint64_t>(number));
  append_little(out, frame);
  append_little(out, settings.serial_number);
  append_little(out, layers);
  append_little(out, static_cast<std::uint32_t>(settings.beams));
  append_little(out, static_cast<std::uint32_t>(settings.echoes));
  for (std::uint32_t i = 0; i < layers; ++i) append_little(out, begin);
  for (std::uint32_t i = 0; i < layers; ++i) append_little(out, begin + took);
  for (const float elevation : settings.elevations)
    append_float(out, static_cast<double>(elevation));
  for (std::uint32_t i = 0; i < layers; ++i) append_float(out, first);
  for (std::uint32_t i = 0; i < layers; ++i) append_float(out, last);
  if (settings.version >= 4) append_float(out, static_cast<double>(settings.factor));
  append_little(out, std::uint32_t{0});           // no next module
  append_little(out, std::uint32_t{0x00030300});  // all values of an echo and of a beam
  for (int beam = 0; beam < settings.beams; ++beam)
    for (const float elevation : settings.elevations)
      append_beam(
          out, settings, first + beam * step * kRadian, static_cast<double>(elevation),
          Time(std::chrono::microseconds(begin + took * static_cast<std::uint64_t>(beam) /
                                                     static_cast<std::uint64_t>(settings.beams))));
  const auto size = static_cast<std::uint32_t>(out.size() - module_at);
  for (std::size_t i = 0; i < 4; ++i) out[size_at + i] = static_cast<std::byte>(size >> 8 * i);
  append_little(out, crc32(std::span(out).subspan(at)));
}

Duration SickCompactEmulator::segment_time() const { return settings_.turn / settings_.segments; }

void SickCompactEmulator::start(Time now, Output& /*out*/) {
  turn_began_ = now;
  segment_ = 0;
  next_ = now + segment_time();
}

void SickCompactEmulator::on_timeout(Time now, Output& out) {
  const auto micros = [](Time time) {
    return static_cast<std::uint64_t>(time.time_since_epoch().count() / 1000);
  };
  while (next_ <= now) {
    datagram_.clear();
    append_compact(datagram_, settings_, frame_, segment_, micros(turn_began_), micros(next_));
    out.send(datagram_);
    if (++segment_ == settings_.segments) {
      segment_ = 0;
      ++frame_;
      turn_began_ += settings_.turn;
    }
    next_ += segment_time();
  }
}

}  // namespace rack::device::emulator
