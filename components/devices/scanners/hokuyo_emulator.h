// Emulator of a Hokuyo scanner: a URG-04LX (or another one by its parameters) with SCIP 2, with
// SCIP 1.1 until it is switched to SCIP 2, or with SCIP 1.1 only.
#pragma once

#include <string>
#include <vector>

#include "components/devices/scanners/room.h"
#include "components/devices/scanners/scip.h"

namespace rack::device::emulator {

enum class HokuyoLanguage : std::uint8_t { kScip2, kScip1First, kScip1Only };

struct HokuyoSettings {
  HokuyoLanguage language = HokuyoLanguage::kScip2;
  std::uint32_t baud = 19200;
  ScipParameters parameters{.model = "URG-04LX(Hokuyo Automatic Co.,Ltd.)"};
  std::string serial_number = "H0614967";
  // Scans to send in turn, starting at step parameters.first; empty: measurements of the scene.
  std::vector<std::vector<std::uint16_t>> scans{};
  Sight sight = Room{};
};

// Reads a log with one scan per line: 24 columns of other values, then distances (BreezySLAM's logs
// of a URG-04LX). `most`: maximum number of scans.
std::vector<std::vector<std::uint16_t>> scans_of_log(std::string_view text, std::size_t most);

class Hokuyo final : public Dialogue {
 public:
  explicit Hokuyo(const HokuyoSettings& settings = {}) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }

  [[nodiscard]] bool measures() const { return next_ != tims::kNever; }
  [[nodiscard]] std::uint32_t baud() const { return baud_; }
  [[nodiscard]] std::size_t scans_sent() const { return sent_; }

 private:
  void answer(std::string_view question, Time now, Output& out);
  void answer_scip1(std::string_view question, Time now, Output& out);
  void answer_scip2(std::string_view question, Time now, Output& out);
  void begin_measuring(std::string_view question, Time now);
  void set_rate(std::string_view digits, Output& out);
  void send(Output& out);
  void begin_answer(std::string_view question, std::string_view status);
  void append_fields(std::initializer_list<std::pair<std::string_view, std::string>> fields);
  void append_scan(const ScipRange& range, Time end, bool has_sums);
  [[nodiscard]] std::uint32_t distance(int step, Time when) const;
  [[nodiscard]] std::uint32_t counter(Time now) const;
  [[nodiscard]] Duration turn() const;

  HokuyoSettings settings_;
  bool uses_scip2_ = false;
  bool compares_clocks_ = false;  // between TM0 and TM2
  std::uint32_t baud_ = 0;
  Time began_{};
  Time next_ = tims::kNever;  // when the next scan is sent
  std::string measuring_;     // the request, without the number of scans
  int left_ = 0;              // remaining scans; below 0: endless
  int skipped_ = 1;
  std::size_t sent_ = 0;
  std::string line_;
  std::string characters_;
  std::string answer_;
};

}  // namespace rack::device::emulator
