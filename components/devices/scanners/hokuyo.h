// Setup and measurement of the Hokuyo scanners URG, UBG, UTM, UST, UXM. See scip.h for the
// protocol.
//
// The dialogue detects the baud rate, stops the scanner and requests SCIP 2. With SCIP 2, it reads
// the identity and the parameters, sets the requested rate, and requests endless scans by MD (ME
// with intensities). Scanners with SCIP 1 only are polled scan by scan. USB and TCP have no baud
// rate.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "components/devices/scanners/scip.h"
#include "rack/devices/device_clock.h"

namespace rack::device {

struct HokuyoSettings {
  int start = 44;  // steps
  int end = 725;
  int cluster = 3;
  std::optional<double> start_angle{};  // angle of `start` to the right, rad; empty: reported one
  std::uint32_t baud = 115200;          // for serial lines
  bool has_rate = true;                 // the line is a serial line
  bool intensities = false;
  std::string serial_number{};  // required serial number; empty: any
  bool only_listen = false;     // the device is a recording
};

class Hokuyo final : public Dialogue {
 public:
  explicit Hokuyo(const HokuyoSettings& settings);

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  void stop(Time now, Output& out) override;

  [[nodiscard]] bool is_ready() const { return has_measured_; }
  bool take(LadarData& scan, Time& recorded);

  [[nodiscard]] bool is_scip1() const { return is_scip1_; }
  [[nodiscard]] const std::string& serial_number() const { return serial_number_; }
  [[nodiscard]] const ScipParameters& parameters() const { return parameters_; }
  [[nodiscard]] std::uint64_t broken() const { return answers_.broken() + broken_; }

 private:
  // In the order of the setup.
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
  void on_rate(const ScipAnswer& answer, Time now, Output& out);
  void on_started(const ScipAnswer& answer, Time now, Output& out);
  void take_scan(const ScipAnswer& answer, Time now, Output& out);
  void refuse(const ScipAnswer& answer);
  [[nodiscard]] std::string question() const;

  HokuyoSettings settings_;
  State state_ = State::kStop;
  std::size_t rate_index_ = 0;
  std::uint32_t rate_ = 0;  // current rate of the line
  std::uint32_t rate_found_ = 0;
  bool switched_ = false;
  bool is_scip1_ = false;
  std::string question_;
  ScipAnswers answers_;
  ScipScans scans_;
  ScipParameters parameters_;
  std::string serial_number_;
  DeviceClock clock_;
  std::uint64_t broken_ = 0;
  LadarData scan_{};
  bool has_scan_ = false;
  bool has_measured_ = false;  // a scan was received since start()
  Time recorded_{};
};

}  // namespace rack::device
