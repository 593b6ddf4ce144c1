// Emulator of a SICK LMS200: answers at its current rate only, changes the rate on request, and
// sends scans of its scene, 75 turns of the mirror per second or fewer if the line is slower.
#pragma once

#include <deque>

#include "components/devices/scanners/lms200.h"
#include "components/devices/scanners/room.h"

namespace rack::device::emulator {

struct Lms200EmulatorSettings {
  std::uint32_t baud = 9600;  // initial rate
  Duration answer_time = std::chrono::milliseconds(20);
  bool is_indoor = true;  // unit mm, else cm with 13 bits
  bool refuses_rates = false;
  Sight sight = Room{};
};

class Lms200Emulator final : public Dialogue {
 public:
  explicit Lms200Emulator(const Lms200EmulatorSettings& settings = {}) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return std::min(answer_at_, scan_at_); }

  [[nodiscard]] std::uint32_t baud() const { return baud_; }
  [[nodiscard]] bool measures() const { return scan_at_ != tims::kNever; }
  [[nodiscard]] bool is_logged_in() const { return is_logged_in_; }
  [[nodiscard]] std::size_t scans_sent() const { return scans_sent_; }

 private:
  // Scans sent without requests.
  enum class Mode : std::uint8_t { kOnRequest, kWhole, kParts };

  void carry_out(std::span<const std::byte> body);
  [[nodiscard]] bool switch_mode(std::span<const std::byte> body);
  void send_scan(Time now, Output& out);
  void append_scan(std::size_t values, unsigned flags, double first, double step, Time end);

  Lms200EmulatorSettings settings_;
  std::uint32_t baud_ = 0;
  std::uint32_t next_baud_ = 0;  // rate after the answer
  Mode mode_ = Mode::kOnRequest;
  Mode next_mode_ = Mode::kOnRequest;
  bool is_logged_in_ = false;
  Lms200Telegrams telegrams_;
  std::deque<std::vector<std::byte>> commands_;  // queue
  std::vector<std::byte> body_;                  // body of a scan
  std::vector<std::byte> answer_;
  std::vector<std::byte> telegram_;
  Time answer_at_ = tims::kNever;
  Time scan_at_ = tims::kNever;
  std::size_t scans_sent_ = 0;
};

}  // namespace rack::device::emulator
