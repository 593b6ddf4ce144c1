// SICK LMS1xx, LMS5xx, TiM and MRS1000 as laser range finders: brought to send every scan by
// itself.
//
// The scanner is asked who it is, in CoLa B and CoLa A by turns, until it answers in one of them.
// Then the host logs in as its authorised client, says which fields it wants, starts the
// measurement, leaves the login and orders the scans. What a scanner refuses on the way is noted
// and passed over: one that is set up already needs none of it.
//
// Every scan carries the scanner's own time, in microseconds since it was switched on; from it
// comes when it was measured, without the jitter of a network.
#pragma once

#include "components/devices/core/device_clock.h"
#include "components/devices/scanners/cola_scan.h"

namespace rack::device {

struct SickColaSettings {
  std::optional<ColaDialect> dialect{};  // nothing: the one it answers in
  std::uint32_t serial_number = 0;       // of the only scanner that will do; 0: any
  ColaView view{};
  bool only_listen = false;  // to a recording
};

class SickCola final : public Dialogue {
 public:
  explicit SickCola(const SickColaSettings& settings);

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  void stop(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return timeout_; }

  // From the first scan on: until then its motor may be starting.
  [[nodiscard]] bool is_ready() const { return state_ == State::kMeasuring; }
  bool take(LadarData& scan, Time& recorded);

  // The newest scan as it came.
  [[nodiscard]] const ColaScan& scan() const { return cola_scan_; }
  [[nodiscard]] ColaDialect dialect() const { return dialect_; }
  [[nodiscard]] std::string serial_number() const {
    return std::to_string(cola_scan_.serial_number);
  }
  // "LMS111 V1.80", as far as it has said.
  [[nodiscard]] const std::string& identity() const { return identity_; }
  // What it has refused since this was asked last, one line each; empty: nothing.
  std::string take_notes() { return std::exchange(notes_, {}); }
  [[nodiscard]] std::uint64_t errors() const { return errors_; }  // sFA
  [[nodiscard]] std::uint64_t broken() const { return telegrams_.broken(); }

 private:
  // In the order in which they are gone through.
  enum class State : std::uint8_t {
    kIdentify,
    kLogin,
    kFields,
    kMeasure,
    kRun,
    kSubscribe,
    kSpinUp,  // waits for the first scan
    kMeasuring,
  };

  void enter(State state, Time now, Output& out);
  void ask(Time now, Output& out);
  void write_question();
  void retry(Time now, Output& out);
  void give_up();
  void hear(const ColaTelegram& telegram, Output& out);
  [[nodiscard]] bool is_answer(const ColaReader& reader) const;
  void on_answer(ColaReader& reader, Time now, Output& out);
  void on_login(bool is_in, Time now, Output& out);
  void on_error(ColaReader& reader, Time now, Output& out);
  void note(std::string_view what);
  void take_scan(const ColaTelegram& telegram);
  Time measured(Time arrived);

  const SickColaSettings settings_;
  State state_ = State::kIdentify;
  ColaDialect dialect_;
  int attempts_ = 0;          // of this question
  std::size_t password_ = 0;  // which one is tried
  bool is_narrow_ = false;    // remission in 8 bits: it has none in 16
  Time timeout_ = tims::kNever;
  ColaTelegrams telegrams_;
  std::vector<std::byte> question_;
  std::vector<std::byte> telegram_;
  std::string identity_;
  std::string notes_;
  std::uint64_t errors_ = 0;
  DeviceClock clock_;
  std::optional<std::uint32_t> transmitted_;  // of the scan before
  ColaScan cola_scan_;
  LadarData scan_{};
  bool has_scan_ = false;
  Time recorded_{};
};

}  // namespace rack::device
