// Emulator of a Firmata board: an Arduino UNO whose outputs are wired to its inputs: pin 13 to pin
// 2, 12 to 3, ... 8 to 7. Its analog inputs read a slow sawtooth.
#pragma once

#include <array>
#include <string_view>

#include "components/devices/pins/firmata.h"

namespace rack::device::emulator {

class IoBoard final : public Dialogue {
 public:
  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }

  [[nodiscard]] bool level(std::size_t pin) const { return levels_.at(pin); }
  void set_level(std::size_t pin, bool high) { levels_.at(pin) = high; }

 private:
  static constexpr std::size_t kPins = 14;
  static constexpr std::size_t kAnalogs = 6;

  void on_message(std::span<const std::byte> message, Output& out);
  void on_long_message(std::span<const std::byte> message, Output& out);
  void report_port(std::size_t port, Output& out);

  FirmataMessages messages_;
  std::array<bool, kPins> levels_{};
  std::array<bool, 2> reports_port_{};
  std::array<bool, kAnalogs> reports_analog_{};
  std::array<unsigned, 2> reported_{};
  Duration interval_ = std::chrono::milliseconds(19);
  Time next_ = tims::kNever;
  unsigned saw_ = 0;
  std::vector<std::byte> sending_;
};

}  // namespace rack::device::emulator
