// Emulator of a scanner with CoLa: has a password, variables and methods, answers sFA to unknown
// requests, and sends scans of its scene or of a recording, with its own timing and counters.
#pragma once

#include "components/devices/scanners/cola_scan.h"
#include "components/devices/scanners/room.h"

namespace rack::device::emulator {

struct SickColaEmulatorSettings {
  ColaDialect dialect = ColaDialect::kBinary;  // ignores the other one
  std::string device = "LMS111";
  std::string version = "V1.80";
  std::uint32_t serial_number = 18090362;
  std::uint32_t password = 0xF4724744;
  bool has_wide_remission = true;
  // Frequency of turns, 1/100 Hz; angles of the scan, 1/10000 degree, counterclockwise from the
  // right.
  std::uint32_t scan_frequency = 5000;
  std::int32_t start_angle = -450000;
  std::uint16_t step = 5000;
  std::uint16_t values = 541;
  Duration answer_time = std::chrono::milliseconds(2);
  Duration spin_up = std::chrono::milliseconds(500);        // from the start to the first scan
  Duration transmits_after = std::chrono::milliseconds(3);  // from the end of a scan to its sending
  Sight sight = Room{};
  // Scans to send repeatedly instead of the scene; their counters continue.
  std::vector<ColaScan> scans{};
};

// Decodes at most `most` scans of a captured stream.
std::vector<ColaScan> scans_of_cola(std::span<const std::byte> stream, std::size_t most);

class SickColaEmulator final : public Dialogue {
 public:
  explicit SickColaEmulator(SickColaEmulatorSettings settings = {})
      : settings_(std::move(settings)) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return std::min(answer_at_, scan_at_); }

  [[nodiscard]] bool measures() const { return measures_; }
  [[nodiscard]] bool is_logged_in() const { return is_logged_in_; }
  [[nodiscard]] bool sends_scans() const { return sends_scans_; }
  [[nodiscard]] std::size_t scans_sent() const { return scans_sent_; }
  [[nodiscard]] std::size_t errors_sent() const { return errors_sent_; }
  // The time of the middle of the newest scan.
  [[nodiscard]] Time measured() const { return measured_; }

 private:
  void take_command(const ColaTelegram& telegram, Time now);
  void take_read(ColaReader& reader);
  void take_write(ColaReader& reader);
  void take_method(ColaReader& reader, Time now);
  void take_event(ColaReader& reader, Time now);
  void append_answer(std::string_view kind, std::string_view name,
                     std::initializer_list<unsigned> bytes);
  void refuse(unsigned number);
  void begin_scans(Time now);
  void send_scan(Output& out);
  void make_scan(Time started);
  [[nodiscard]] std::uint32_t counter(Time now) const;
  [[nodiscard]] Duration scan_time() const;
  [[nodiscard]] Duration turn() const;

  SickColaEmulatorSettings settings_;
  bool is_logged_in_ = false;
  bool measures_ = false;
  bool sends_scans_ = false;
  bool has_remission_ = false;
  bool is_wide_ = false;
  ColaTelegrams telegrams_;
  std::vector<std::byte> body_;
  std::vector<std::byte> answers_;  // complete telegrams, sent when due
  std::vector<std::byte> telegram_;
  ColaScan scan_;
  Time switched_on_{};
  Time turns_since_ = tims::kNever;  // when the mirror reached its speed
  Time answer_at_ = tims::kNever;
  Time scan_at_ = tims::kNever;  // when the next scan is sent
  Time measured_{};
  std::size_t scans_sent_ = 0;
  std::size_t errors_sent_ = 0;
};

}  // namespace rack::device::emulator
