#include "components/devices/scanners/sick_s_emulator.h"

#include <algorithm>
#include <numbers>

#include "rack/devices/device_clock.h"

namespace rack::device::emulator {

using namespace std::chrono_literals;

namespace {

constexpr Duration turn_of(SickSDevice device) {
  return device == SickSDevice::kS300 ? 40ms : 30ms;
}

}  // namespace

void append_sick_s_scan(std::vector<std::byte>& blocks, SickSDevice device, const Sight& sight,
                        Time end) {
  const bool is_small = device == SickSDevice::kS300;
  const int values = is_small ? 541 : 381;
  const double right = is_small ? 135 : 95;
  constexpr int kValuesOfTurn = 720;
  constexpr double kRange = 81900;  // largest value, sent if there is no echo
  for (const unsigned byte : {0xBBU, 0xBBU, 0x11U, 0x11U})
    blocks.push_back(static_cast<std::byte>(byte));
  for (int i = 0; i < values; ++i) {
    const double angle = (right - 0.5 * i) * std::numbers::pi / 180;
    const Time when = end - turn_of(device) * (values - 1 - i) / kValuesOfTurn;
    const auto value =
        static_cast<unsigned>(std::lround(std::min(sight(angle, 0, when), kRange) / 10));
    blocks.push_back(static_cast<std::byte>(value));
    blocks.push_back(static_cast<std::byte>(value >> 8));
  }
}

void SickSEmulator::start(Time now, Output& out) {
  out.set_baud(settings_.baud);
  scan_at_ = now;
}

void SickSEmulator::on_timeout(Time now, Output& out) {
  if (scan_at_ > now) return;
  constexpr std::array kInputs = {std::byte{0xAA}, std::byte{0xAA}, std::byte{0x01},
                                  std::byte{0x00}};
  if (settings_.sends_inputs) send(kInputs, out);
  blocks_.clear();
  append_sick_s_scan(blocks_, settings_.device, settings_.sight, scan_at_);
  ++scans_sent_;
  send(blocks_, out);
  // At lower rates, the next scan waits until the line is free.
  const Duration turn = turn_of(settings_.device);
  const Duration busy = line_time(telegram_.size(), settings_.baud);
  while (scan_at_ <= now) scan_at_ += turn * ((busy + turn) / turn);
}

void SickSEmulator::send(std::span<const std::byte> blocks, Output& out) {
  telegram_.clear();
  append_sick_s(telegram_, {.address = static_cast<std::uint8_t>(settings_.is_slave ? 8 : 7),
                            .scan_number = scans_sent_,
                            .blocks = blocks});
  out.send(telegram_);
}

}  // namespace rack::device::emulator
