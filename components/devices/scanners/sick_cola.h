// Setup and measurement of the SICK laser range finders LMS1xx, LMS5xx, TiM and MRS1000.
//
// The dialogue requests the identity in CoLa B and CoLa A alternately until the scanner answers. It
// then logs in as authorised client, selects the fields of scans, starts the measurement, logs out
// and subscribes to the scans. Refused requests are noted and skipped, because a scanner that is
// already configured does not need them.
//
// Every scan contains the time of the scanner in microseconds since power-on, from which the time
// of measurement is computed without the jitter of the network.
#pragma once

#include "components/devices/scanners/cola_scan.h"
#include "rack/devices/device_clock.h"

namespace rack::device {

struct SickColaSettings {
  std::optional<ColaDialect> dialect{};  // empty: detect
  std::uint32_t serial_number = 0;       // required serial number; 0: any
  ColaView view{};                       // the front is set by the dialogue
  std::optional<double> front{};         // angle of the front [deg]; empty: by name or range
  bool only_listen = false;              // the device is a recording
};

class SickCola final : public Dialogue {
 public:
  explicit SickCola(const SickColaSettings& settings);

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  void stop(Time now, Output& out) override;

  // True after the first scan: before that the motor may still be starting.
  [[nodiscard]] bool is_ready() const { return state_ == State::kMeasuring; }
  bool take(LadarData& scan, Time& recorded);

  // The newest scan as received.
  [[nodiscard]] const ColaScan& scan() const { return cola_scan_; }
  [[nodiscard]] ColaDialect dialect() const { return dialect_; }
  [[nodiscard]] std::string serial_number() const {
    return std::to_string(cola_scan_.serial_number);
  }
  // For example "LMS111 V1.80", as far as known.
  [[nodiscard]] const std::string& identity() const { return identity_; }
  // The front used for the newest scan.
  [[nodiscard]] ColaFront front() const;
  // Requests refused since the last call, one line each.
  std::string take_notes() { return std::exchange(notes_, {}); }
  [[nodiscard]] std::uint64_t errors() const { return errors_; }  // sFA
  [[nodiscard]] std::uint64_t broken() const { return telegrams_.broken(); }

 private:
  // In the order of the setup.
  enum class State : std::uint8_t {
    kIdentify,
    kLogin,
    kFields,
    kMeasure,
    kRun,
    kSubscribe,
    kSpinUp,  // waiting for the first scan
    kMeasuring,
  };

  void enter(State state, Time now, Output& out);
  void ask(Time now, Output& out);
  void write_question();
  void give_up();
  void receive(const ColaTelegram& telegram, Output& out);
  [[nodiscard]] bool is_answer(const ColaReader& reader) const;
  void on_answer(ColaReader& reader, Time now, Output& out);
  void take_identity(ColaReader& reader);
  void on_login(bool is_in, Time now, Output& out);
  void on_error(ColaReader& reader, Time now, Output& out);
  void note(std::string_view what);
  void take_scan(const ColaTelegram& telegram);
  Time measured(Time arrived);

  const SickColaSettings settings_;
  State state_ = State::kIdentify;
  ColaDialect dialect_;
  std::size_t password_ = 0;  // index of the password being tried
  bool is_narrow_ = false;    // remission in 8 bits, because 16 bits are not supported
  ColaTelegrams telegrams_;
  std::vector<std::byte> question_;
  std::vector<std::byte> telegram_;
  std::string identity_;
  std::optional<ColaFront> named_front_;
  std::string notes_;
  std::uint64_t errors_ = 0;
  DeviceClock clock_;
  std::optional<std::uint32_t> transmitted_;  // of the previous scan
  ColaScan cola_scan_;
  LadarData scan_{};
  bool has_scan_ = false;
  Time recorded_{};
};

}  // namespace rack::device
