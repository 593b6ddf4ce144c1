#include "components/devices/pins/firmata.h"

#include <algorithm>
#include <array>
#include <utility>

namespace rack::device {
namespace {

using namespace std::chrono_literals;
using namespace firmata;

constexpr int kAttempts = 5;  // a board does not answer for two seconds after a reset
constexpr Duration kAnswerTime = 1s;
constexpr Duration kSilence = 1s;
constexpr std::size_t kMessageMax = 512;
constexpr unsigned kSevenBits = 0x7F;

unsigned number(std::byte byte) { return std::to_integer<unsigned>(byte); }

// Size of a message by its command, except F0 ... F7. 0: not a command.
std::size_t size_of(unsigned command) {
  const unsigned kind = command < 0xF0 ? command & 0xF0 : command;
  if (kind == kDigital || kind == kAnalog || kind == kVersion || kind == kMode || kind == kSetPin)
    return 3;
  if (kind == kReportAnalog || kind == kReportDigital) return 2;
  return 0;
}

}  // namespace

namespace firmata {
void append(std::vector<std::byte>& out, std::initializer_list<unsigned> bytes) {
  for (const unsigned byte : bytes) out.push_back(static_cast<std::byte>(byte));
}
}  // namespace firmata

std::optional<std::span<const std::byte>> FirmataMessages::next() {
  buffer_.consume(std::exchange(used_, 0));
  while (buffer_.size() > 0) {
    const auto bytes = buffer_.bytes();
    const unsigned command = number(bytes.front());
    const auto is_command = [](std::byte byte) { return number(byte) > kSevenBits; };
    // The data bytes of seven bits that follow.
    const auto end = std::find_if(bytes.begin() + 1, bytes.end(), is_command);
    const auto size = static_cast<std::size_t>(end - bytes.begin());
    if (command == kBegin) {
      if (end == bytes.end() && size < kMessageMax) return std::nullopt;
      const bool is_whole = end != bytes.end() && number(*end) == kEnd;
      if (!is_whole) {
        buffer_.consume(size);
        continue;
      }
      used_ = size + 1;
      return bytes.first(size + 1);
    }
    const std::size_t needed = size_of(command);
    if (needed != 0 && size < needed && end == bytes.end()) return std::nullopt;
    if (needed == 0 || size < needed) {
      buffer_.consume(1);
      continue;
    }
    used_ = needed;
    return bytes.first(needed);
  }
  return std::nullopt;
}

void Firmata::start(Time now, Output& out) {
  reset();
  messages_.clear();
  timer_.reset();
  last_received_ = now;
  if (!settings().only_listen) ask_firmware(now, out);
}

void Firmata::ask_firmware(Time now, Output& out) {
  sending_.clear();
  append(sending_, {kBegin, kFirmware, kEnd});
  out.send(sending_);
  timer_.sent(now, kAnswerTime);
}

Time Firmata::next_timeout() const { return has_pending() && is_ready() ? Time{} : timer_.due(); }

void Firmata::on_timeout(Time now, Output& out) {
  if (settings().only_listen || failure()) return;
  if (has_pending() && is_ready()) send_outputs(now, out);
  if (!timer_.take_due(now)) return;
  if (!is_ready() && timer_.may_repeat(kAttempts)) {
    ask_firmware(now, out);
  } else if (!is_ready() ||
             now - last_received_ > std::max<Duration>(kSilence, 3 * settings().period)) {
    fail(tims::Errc::kTimeout,
         is_ready() ? "the board has stopped sending"
                    : "the board does not answer; check that it runs Firmata at 57600 baud");
  } else {
    // Requests the firmware periodically to detect a lost board: unchanged inputs send nothing.
    sending_.clear();
    append(sending_, {kVersion});
    out.send(sending_);
    timer_.wait_until(now + settings().period);
  }
}

void Firmata::on_arrival(const Arrival& arrival, Output& out) {
  messages_.add(arrival);
  while (const auto message = messages_.next()) on_message(*message, arrival.last, out);
}

void Firmata::on_message(std::span<const std::byte> message, Time when, Output& out) {
  const unsigned command = number(message.front());
  last_received_ = when;
  if (command == kBegin && message.size() >= 5 && number(message[1]) == kFirmware) {
    on_firmware(message, when, out);
  } else if (command == kVersion) {
    publish(when);
  } else if ((command & 0xF0) == kDigital) {
    const unsigned levels = number(message[1]) | number(message[2]) << 7;
    const unsigned first = (command & 0xF) * 8;
    for (unsigned i = 0; i < 8; ++i)
      if (const auto input = index_of(settings().layout.inputs, first + i))
        on_input(*input, (levels >> i & 1) != 0, when);
  } else if ((command & 0xF0) == kAnalog) {
    const unsigned value = number(message[1]) | number(message[2]) << 7;
    if (const auto analog = index_of(settings().layout.analogs, command & 0xF))
      on_analog(*analog, static_cast<u8>(std::min(255U, value >> 2)), when);
  }
}

// A board also sends this message after a reset, so it is configured again.
void Firmata::on_firmware(std::span<const std::byte> message, Time now, Output& out) {
  firmware_.clear();
  for (std::size_t i = 4; i + 2 < message.size(); i += 2)
    firmware_ += static_cast<char>(number(message[i]) | number(message[i + 1]) << 7);
  firmware_ += " " + std::to_string(number(message[2])) + "." + std::to_string(number(message[3]));
  if (!settings().only_listen) {
    set_up(out);
    set_ready(true);
    timer_.wait_until(now + settings().period);
  }
  publish(now);
}

void Firmata::set_up(Output& out) {
  const IoLayout& layout = settings().layout;
  sending_.clear();
  for (const unsigned pin : layout.inputs) {
    append(sending_, {kMode, pin, layout.pull_up ? kModePullUp : kModeInput});
    append(sending_, {kReportDigital + pin / 8, 1});
  }
  for (const unsigned pin : layout.outputs) append(sending_, {kMode, pin, kModeOutput});
  for (const unsigned pin : layout.analogs) append(sending_, {kReportAnalog + pin, 1});
  if (!layout.analogs.empty()) {
    const auto interval =
        static_cast<unsigned>(std::clamp<std::int64_t>(settings().period / 1ms, 10, 0x3FFF));
    append(sending_,
           {kBegin, kSamplingInterval, interval & kSevenBits, interval >> 7 & kSevenBits, kEnd});
  }
  out.send(sending_);
}

void Firmata::send_outputs(Time now, Output& out) {
  const auto pending = take_pending(now);
  sending_.clear();
  for (std::size_t i = 0; i < pending.size(); ++i)
    append(sending_, {kSetPin, settings().layout.outputs[i], pending[i] != 0 ? 1U : 0U});
  out.send(sending_);
}

}  // namespace rack::device
