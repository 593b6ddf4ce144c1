#include "components/devices/pins/io_board.h"

namespace rack::device::emulator {
namespace {

using namespace firmata;

constexpr std::string_view kName = "StandardFirmata.ino";

unsigned number(std::byte byte) { return std::to_integer<unsigned>(byte); }

}  // namespace

void IoBoard::start(Time now, Output&) {
  messages_.clear();
  reports_port_ = {};
  reports_analog_ = {};
  next_ = now + interval_;
}

void IoBoard::on_arrival(const Arrival& arrival, Output& out) {
  messages_.add(arrival);
  // A request for the version consists of the command only.
  for (const std::byte byte : arrival.bytes) {
    if (number(byte) != kVersion) continue;
    sending_.clear();
    append(sending_, {kVersion, 2, 6});
    out.send(sending_);
  }
  while (const auto message = messages_.next()) on_message(*message, out);
}

void IoBoard::on_timeout(Time now, Output& out) {
  next_ = now + interval_;
  for (std::size_t port = 0; port < reports_port_.size(); ++port)
    if (reports_port_.at(port)) report_port(port, out);
  saw_ = (saw_ + 8) % 1024;
  sending_.clear();
  for (unsigned i = 0; i < kAnalogs; ++i)
    if (reports_analog_.at(i)) append(sending_, {kAnalog + i, saw_ & 0x7F, saw_ >> 7});
  if (!sending_.empty()) out.send(sending_);
}

void IoBoard::report_port(std::size_t port, Output& out) {
  unsigned levels = 0;
  for (std::size_t i = 0; i < 8 && port * 8 + i < kPins; ++i)
    levels |= levels_.at(port * 8 + i) ? 1U << i : 0U;
  if (levels == reported_.at(port)) return;
  reported_.at(port) = levels;
  sending_.clear();
  append(sending_, {kDigital + static_cast<unsigned>(port), levels & 0x7F, levels >> 7});
  out.send(sending_);
}

void IoBoard::on_message(std::span<const std::byte> message, Output& out) {
  const unsigned command = number(message.front());
  if (command == kBegin) {
    on_long_message(message, out);
  } else if (command == kSetPin) {
    const unsigned pin = number(message[1]);
    if (pin < 2 || pin >= kPins) return;
    levels_.at(pin) = number(message[2]) != 0;
    if (pin >= 8) levels_.at(15 - pin) = levels_.at(pin);
  } else if ((command & 0xF0) == kReportDigital && (command & 0xF) < reports_port_.size()) {
    reports_port_.at(command & 0xF) = number(message[1]) != 0;
    reported_.at(command & 0xF) = ~0U;  // the current value is reported at once
    report_port(command & 0xF, out);
  } else if ((command & 0xF0) == kReportAnalog && (command & 0xF) < kAnalogs) {
    reports_analog_.at(command & 0xF) = number(message[1]) != 0;
  }
}

void IoBoard::on_long_message(std::span<const std::byte> message, Output& out) {
  const unsigned what = message.size() > 2 ? number(message[1]) : 0;
  if (what == kFirmware) {
    sending_.clear();
    append(sending_, {kBegin, kFirmware, 2, 6});
    for (const char c : kName)
      append(sending_, {static_cast<unsigned>(c) & 0x7F, static_cast<unsigned>(c) >> 7 & 0x7F});
    append(sending_, {kEnd});
    out.send(sending_);
  } else if (what == kSamplingInterval && message.size() == 5) {
    interval_ =
        std::chrono::milliseconds(std::max(10U, number(message[2]) | number(message[3]) << 7));
  }
}

}  // namespace rack::device::emulator
