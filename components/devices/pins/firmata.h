// I/O boards with Firmata on USB or a serial line, for example Arduino.
//
// A byte with its highest bit set begins a message. 9p: levels of the eight pins of port p, two
// bytes of seven bits; Ep: analog input p, ten bits; F4: pin mode; F5: pin level; Cp, Dp: enable
// reports of analog input or port p; F9: version; F0 ... F7: longer messages, of which 79 is the
// name of the firmware. 57600 baud. Opening the line resets most boards: they do not answer for two
// seconds.
//
// Source: the protocol's description (github.com/firmata/protocol), version 2.6.
#pragma once

#include <string>

#include "components/devices/pins/io_lines.h"
#include "rack/devices/stream_buffer.h"

namespace rack::device {

namespace firmata {
inline constexpr std::uint8_t kDigital = 0x90;  // + port
inline constexpr std::uint8_t kReportAnalog = 0xC0;
inline constexpr std::uint8_t kReportDigital = 0xD0;
inline constexpr std::uint8_t kAnalog = 0xE0;
inline constexpr std::uint8_t kBegin = 0xF0;
inline constexpr std::uint8_t kMode = 0xF4;
inline constexpr std::uint8_t kSetPin = 0xF5;
inline constexpr std::uint8_t kEnd = 0xF7;
inline constexpr std::uint8_t kVersion = 0xF9;
inline constexpr std::uint8_t kFirmware = 0x79;
inline constexpr std::uint8_t kSamplingInterval = 0x7A;
inline constexpr std::uint8_t kModeInput = 0;
inline constexpr std::uint8_t kModeOutput = 1;
inline constexpr std::uint8_t kModeAnalog = 2;
inline constexpr std::uint8_t kModePullUp = 11;

void append(std::vector<std::byte>& out, std::initializer_list<unsigned> bytes);
}  // namespace firmata

// Splits a stream into messages; each begins with its command.
class FirmataMessages {
 public:
  void add(const Arrival& arrival) { buffer_.add(arrival); }
  // Valid until the next call.
  std::optional<std::span<const std::byte>> next();
  void clear() { buffer_.clear(); }

 private:
  StreamBuffer buffer_{1024};
  std::size_t used_ = 0;
};

class Firmata final : public IoLines {
 public:
  explicit Firmata(const IoSettings& settings) : IoLines(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override;

  // For example "StandardFirmata.ino 2.5".
  [[nodiscard]] const std::string& firmware() const { return firmware_; }

 private:
  void ask_firmware(Time now, Output& out);
  void on_firmware(std::span<const std::byte> message, Time now, Output& out);
  void on_message(std::span<const std::byte> message, Time when, Output& out);
  void set_up(Output& out);
  void send_outputs(Time now, Output& out);

  FirmataMessages messages_;
  std::string firmware_;
  Time last_received_{};
  std::vector<std::byte> sending_;
};

}  // namespace rack::device
