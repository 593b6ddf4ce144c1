// Radio clocks that receive DCF77, the time signal of central Europe, and send a telegram each
// second.
//
// Meinberg (C51 and others), 9600 baud: 02 "D:dd.mm.yy;T:w;U:hh.mm.ss;uvxy" 03. u '#': never
// synchronised, v '*': free running; x ' ': CET, 'S': CEST, 'U': UTC; y '!' or 'A': announces a
// change of daylight saving time or a leap second. The first bit marks the beginning of the second.
// The factory setting is seven bits, even parity and two stop bits. The line is read as eight bits
// without parity and the upper bit is ignored, so that both settings work.
//
// Gude EMC Professional, 9600 8N1: "<hhmmddmmyywZeeSUA000ss>cc" CR. Z 'F': synchronised, 'Q': free
// running; S: CEST; cc: the sum of all characters including the brackets, in hex. The last
// character is sent 22 ms after the beginning of the second.
//
// Both send local time. The fields of ClockData contain this local time, as in the original;
// utcTime is UTC, whereas the original stores local time in it.
//
// Source: Meinberg, "Format of the Meinberg Standard Time String"; Gude Systems, "V.24
// Ausgabeprotokoll"; RACK 0.6.1.
#pragma once

#include <optional>
#include <string_view>

#include "rack/devices/stream_buffer.h"
#include "rack/proxies/clock.h"

namespace rack::device {

enum class Dcf77Kind : std::uint8_t { kMeinberg, kEmcPro };

// Parses a complete telegram, from its first to its last character (03, or the one before CR).
// Returns false for invalid telegrams and impossible times. Does not change recordingTime.
bool parse_meinberg(std::string_view telegram, ClockData& clock);
bool parse_emc_pro(std::string_view telegram, ClockData& clock);

class Dcf77 final : public Dialogue {
 public:
  explicit Dcf77(Dcf77Kind kind) : kind_(kind) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;

  [[nodiscard]] bool is_ready() const { return has_received_; }
  // `recorded`: when the second of the telegram began.
  bool take(ClockData& clock, Time& recorded);
  [[nodiscard]] Time recorded() const { return recorded_; }
  [[nodiscard]] std::uint64_t broken() const { return broken_; }

 private:
  static constexpr std::size_t kTelegramMax = 64;

  void take_byte(char c, const Arrival& arrival, std::size_t index);

  Dcf77Kind kind_;
  std::array<char, kTelegramMax> text_{};
  std::size_t size_ = 0;  // 0: waits for the start of a telegram
  Time began_{};
  std::uint64_t bytes_ = 0;
  std::uint64_t broken_ = 0;
  bool has_received_ = false;
  bool has_data_ = false;
  ClockData data_{};
  Time recorded_{};
};

}  // namespace rack::device
