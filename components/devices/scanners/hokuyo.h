// Hokuyo URG, UBG, UTM, UST, UXM: how one of them is brought to measure. See scip.h for what is
// said.
//
// Whatever it does is stopped, at whatever rate its line has; then SCIP 2 is asked for. With it:
// who it is, what it can measure, the rate that is wanted, MD (ME with intensities) without end.
// Scanners that know SCIP 1 only are asked scan by scan. USB and TCP have no rate.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "components/devices/core/device_clock.h"
#include "components/devices/scanners/scip.h"

namespace rack::device {

struct HokuyoSettings {
  int start = 44;  // steps
  int end = 725;
  int cluster = 3;
  std::optional<double> start_angle{};  // where `start` looks, to the right, rad; else it says so
  std::uint32_t baud = 115200;          // of a serial line
  bool has_rate = true;                 // it is a serial line
  bool intensities = false;
  std::string serial_number{};  // of the only scanner that will do; empty: any
  bool only_listen = false;     // to a recording
};

class Hokuyo final : public Dialogue {
 public:
  explicit Hokuyo(const HokuyoSettings& settings);

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  void stop(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return timeout_; }

  [[nodiscard]] bool is_ready() const { return has_measured_; }
  bool take(LadarData& scan, Time& recorded);

  [[nodiscard]] bool is_scip1() const { return is_scip1_; }
  [[nodiscard]] const std::string& serial_number() const { return serial_number_; }
  [[nodiscard]] const ScipParameters& parameters() const { return parameters_; }
  [[nodiscard]] std::uint64_t broken() const { return answers_.broken() + broken_; }

 private:
  // In the order in which they are gone through.
  enum class State : std::uint8_t {
    kStop,
    kSwitch,
    kVersion,
    kParameters,
    kRate,
    kStart,
    kMeasuring,
  };

  void enter(State state, Time now, Output& out);
  void ask(Time now, Output& out);
  void retry(Time now, Output& out);
  void try_next_rate(Time now, Output& out);
  void take_answer(const ScipAnswer& answer, Time now, Output& out);
  void on_stopped(const ScipAnswer& answer, Time now, Output& out);
  bool is_right_one();
  void on_rate(const ScipAnswer& answer, Time now, Output& out);
  void on_started(const ScipAnswer& answer, Time now, Output& out);
  void take_scan(const ScipAnswer& answer, Time now, Output& out);
  void refuse(const ScipAnswer& answer);
  [[nodiscard]] std::string question() const;

  HokuyoSettings settings_;
  State state_ = State::kStop;
  std::size_t rate_index_ = 0;
  std::uint32_t rate_ = 0;  // of the line, now
  std::uint32_t rate_found_ = 0;
  int attempts_ = 0;  // of this question
  bool switched_ = false;
  bool is_scip1_ = false;
  Time timeout_ = tims::kNever;
  std::string question_;
  ScipAnswers answers_;
  ScipScans scans_;
  ScipParameters parameters_;
  std::string serial_number_;
  DeviceClock clock_;
  std::uint64_t broken_ = 0;
  LadarData scan_{};
  bool has_scan_ = false;
  bool has_measured_ = false;  // since start()
  Time recorded_{};
};

}  // namespace rack::device
