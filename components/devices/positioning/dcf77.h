// Clocks that hear DCF77, the time signal of central Europe, and send a telegram each second.
//
// Meinberg (C51 and others), 9600 baud: 02 "D:dd.mm.yy;T:w;U:hh.mm.ss;uvxy" 03. u '#': never
// synchronised, v '*': runs by itself; x ' ': CET, 'S': CEST, 'U': UTC; y '!' or 'A': a change of
// the zone, or a leap second, comes. Its first bit is the beginning of the second. The clock is
// delivered with seven bits, even parity and two stop bits; read as eight bits without parity only
// the upper bit is strange, which is left out: both ways of setting it work.
//
// Gude EMC Professional, 9600 8N1: "<hhmmddmmyywZeeSUA000ss>cc" CR. Z 'F': synchronised, 'Q': runs
// by itself; S: CEST; cc: the sum of all characters, brackets included, in hex. Its last character
// comes 22 ms after the beginning of the second.
//
// Both show the time of the zone. The fields of ClockData are what the clock shows, as in the
// original; utcTime is UTC, which the original takes the time of the zone for.
//
// Source: Meinberg, "Format of the Meinberg Standard Time String"; Gude Systems, "V.24
// Ausgabeprotokoll"; RACK 0.6.1.
#pragma once

#include <optional>
#include <string_view>

#include "components/devices/core/stream_buffer.h"
#include "rack/proxies/clock.h"

namespace rack::device {

enum class Dcf77Kind : std::uint8_t { kMeinberg, kEmcPro };

// A whole telegram, from its first character to its last one: 03, or what stands before CR. False:
// it is none, or none of a real time. recordingTime stays as it is.
bool parse_meinberg(std::string_view telegram, ClockData& clock);
bool parse_emc_pro(std::string_view telegram, ClockData& clock);

class Dcf77 final : public Dialogue {
 public:
  explicit Dcf77(Dcf77Kind kind) : kind_(kind) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return timeout_; }

  [[nodiscard]] bool is_ready() const { return has_heard_; }
  // `recorded`: when the second began that it tells.
  bool take(ClockData& clock, Time& recorded);
  [[nodiscard]] Time recorded() const { return recorded_; }
  [[nodiscard]] std::uint64_t broken() const { return broken_; }

 private:
  static constexpr std::size_t kTelegramMax = 64;

  void take_byte(char c, const Arrival& arrival, std::size_t index);

  Dcf77Kind kind_;
  std::array<char, kTelegramMax> text_{};
  std::size_t size_ = 0;  // 0: waits for a beginning
  Time began_{};
  std::uint64_t bytes_ = 0;
  std::uint64_t broken_ = 0;
  bool has_heard_ = false;
  Time timeout_ = tims::kNever;
  bool has_data_ = false;
  ClockData data_{};
  Time recorded_{};
};

}  // namespace rack::device
