// SICK LMS200, LMS211, LMS221, LMS291 over a serial line.
//
// A telegram is 02, address, length (u16), body, CRC (u16), all little-endian. The scanner
// acknowledges a telegram by 06 or refuses it by 15 within 60 ms, and answers within seconds. It
// starts at 9600 baud, unless its rate was changed before. The dialogue sets the requested rate and
// then starts continuous output of scans.
//
// Source: SICK's "Telegrams for configuring and operating the LMS2xx"; RACK 0.6.1.
#pragma once

#include <array>
#include <optional>

#include "rack/devices/device_clock.h"
#include "rack/devices/stream_buffer.h"
#include "rack/proxies/ladar.h"

namespace rack::device {

inline constexpr Duration kLms200Turn =
    std::chrono::nanoseconds(1'000'000'000 / 75);  // one turn of the mirror

struct Lms200Telegram {
  std::uint8_t address = 0;
  std::span<const std::byte> body{};  // without CRC; valid until the next call
  Time began{};                       // when its first byte was on the line
};

// CRC with polynomial 8005 over pairs of bytes.
std::uint16_t lms200_crc(std::span<const std::byte> bytes);
// Appends a complete telegram to the scanner.
void append_lms200(std::vector<std::byte>& out, std::span<const std::byte> body,
                   std::uint8_t address = 0);

class Lms200Telegrams {
 public:
  enum class What : std::uint8_t { kNothing, kTelegram, kAcknowledged, kRefused };

  void add(const Arrival& arrival) { buffer_.add(arrival); }
  What next(Lms200Telegram& telegram);
  void clear() { buffer_.clear(); }

  // Number of telegrams with a wrong CRC.
  [[nodiscard]] std::uint64_t broken() const { return broken_; }

 private:
  // Longest body: 401 values and their header; a longer length is invalid.
  static constexpr std::size_t kBodyMax = 812;
  static constexpr std::size_t kFrame = 6;

  StreamBuffer buffer_{4 * (kBodyMax + kFrame)};
  std::uint64_t broken_ = 0;
  std::size_t used_ = 0;  // size of the telegram that was returned
};

// Converts the body of a measurement (B0) to a clockwise scan. Returns false for other bodies.
bool decode_lms200_scan(std::span<const std::byte> body, LadarData& scan);

enum class Lms200Mode : std::uint8_t { kNormal, kInterlaced, kFast };

struct Lms200Settings {
  std::uint32_t baud = 38400;  // 9600, 19200, 38400 or 500000
  Lms200Mode mode = Lms200Mode::kNormal;
  bool only_listen = false;  // the device is a recording
};

class Lms200 final : public Dialogue {
 public:
  explicit Lms200(const Lms200Settings& settings) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  void stop(Time now, Output& out) override;

  // A recording may begin with the log-in: it is ready from its first scan on.
  [[nodiscard]] bool is_ready() const {
    return state_ == State::kMeasuring && (!settings_.only_listen || recorded_ != Time{});
  }
  bool take(LadarData& scan, Time& recorded);
  [[nodiscard]] std::uint64_t broken() const { return telegrams_.broken(); }

 private:
  // In the order of the setup.
  enum class State : std::uint8_t { kLogin, kRate, kStart, kMeasuring };

  void enter(State state, Time now, Output& out);
  void ask(Time now, Output& out);
  void on_answer(Time now, Output& out);
  void retry(Time now, Output& out);
  void log_in_at_wanted_rate(Time now, Output& out);
  void take_scan(const Lms200Telegram& telegram);

  Lms200Settings settings_;
  State state_ = State::kLogin;
  std::uint32_t rate_ = 0;  // current rate of the line
  bool acknowledged_ = false;
  bool pausing_ = false;  // the scanner needs a pause of 30 ms after an answer
  bool refused_ = false;  // the current request was refused
  Lms200Telegrams telegrams_;
  std::vector<std::byte> question_;
  LadarData scan_{};
  bool has_scan_ = false;
  Time recorded_{};
  TurnClock clock_{kLms200Turn};
};

}  // namespace rack::device
