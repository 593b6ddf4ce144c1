// A CMPS03 compass behind a small board with a serial line (57600 baud).
//
// The board sends "$dddd" and LF, tenths of a degree from magnetic north, clockwise. For
// calibration, the compass is turned to each of the four directions; at each one, the host sends
// 7E, the board answers "$OK", and the host sends 23. The compass stores the calibration.
//
// Source: RACK 0.6.1; Devantech's description of the compass: 0.1 deg resolution, 3 to 4 deg
// accuracy, four directions to calibrate.
#pragma once

#include <optional>
#include <string_view>

#include "rack/devices/stream_buffer.h"
#include "rack/proxies/compass.h"

namespace rack::device {

namespace cmps03 {
inline constexpr std::byte kCalibrate{0x7E};  // '~'
inline constexpr std::byte kConfirm{0x23};    // '#'
inline constexpr int kDirections = 4;
}  // namespace cmps03

// Parses a line without its line end: "$1234" is 123.4 deg. Empty if the line is invalid.
std::optional<double> parse_cmps03(std::string_view line);

struct Cmps03Settings {
  double offset = 0;  // deg, added to the heading
};

class Cmps03 final : public Dialogue {
 public:
  // Steps of the calibration to report to the user.
  enum class Step : std::uint8_t { kNone, kAlign, kConfirmed, kSilent, kDone, kEnded };

  explicit Cmps03(const Cmps03Settings& settings) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;

  [[nodiscard]] bool is_ready() const { return has_received_ && !is_calibrating(); }
  bool take(CompassData& data, Time& recorded);

  // Requests of the user: to calibrate; and that the compass has been aligned as requested by
  // take_step(). They take effect at the next timeout of the dialogue.
  void request_calibration(bool wanted, bool aligned, Time now);
  [[nodiscard]] bool is_calibrating() const { return state_ != State::kMeasuring; }
  // Returns each step to report once; `direction`: 1 to 4.
  Step take_step(int& direction);

 private:
  // kAligning: waits for the user; kAsked: waits for OK.
  enum class State : std::uint8_t { kMeasuring, kAligning, kAsked };
  static constexpr std::size_t kLineMax = 64;

  void on_line(std::string_view line, Time began, Time now, Output& out);
  void on_confirmed(Output& out);
  void forget_noise();
  void set_step(Step step) { step_ = step; }

  Cmps03Settings settings_;
  StreamBuffer buffer_{2048};
  State state_ = State::kMeasuring;
  int direction_ = 1;
  bool ask_ = false;  // send the request at the next opportunity
  Step step_ = Step::kNone;
  int step_direction_ = 1;
  bool has_received_ = false;
  std::uint64_t bytes_ = 0;
  bool has_data_ = false;
  CompassData data_{};
  Time recorded_{};
};

}  // namespace rack::device
