// Inputs and outputs, whatever they are at: what the program Io asks of its dialogue.
//
// Values are bytes: of each input and then of each output 0 or 1, then of each analog input 0 to
// 255, in the order in which they were asked for.
#pragma once

#include <optional>
#include <vector>

#include "components/devices/core/dialogue.h"
#include "rack/proxies/io.h"

namespace rack::device {

struct IoLayout {
  std::vector<std::uint16_t> inputs{};  // numbers of pins or lines
  std::vector<std::uint16_t> outputs{};
  std::vector<std::uint16_t> analogs{};
  bool pull_up = false;  // inputs that nothing drives are high
};

struct IoSettings {
  IoLayout layout{};
  Duration period = std::chrono::milliseconds(100);  // at least so often; changes are told at once
  bool only_listen = false;                          // to a recording
};

class IoLines : public Dialogue {
 public:
  // Outputs, in their order; sent at the next on_timeout(), which is due at once.
  void set(std::span<const u8> outputs);
  [[nodiscard]] bool is_ready() const { return is_ready_; }
  bool take(IoData& data, Time& recorded);

 protected:
  explicit IoLines(const IoSettings& settings);

  [[nodiscard]] const IoSettings& settings() const { return settings_; }
  // Which of `pins` it is.
  static std::optional<std::size_t> index_of(const std::vector<std::uint16_t>& pins,
                                             std::uint32_t pin);
  void set_ready(bool ready) { is_ready_ = ready; }
  void reset();
  void on_input(std::size_t index, bool high, Time when);
  void on_output(std::size_t index, bool high, Time when);
  void on_analog(std::size_t index, u8 value, Time when);
  // As it is now, also when nothing changed.
  void publish(Time when);
  [[nodiscard]] bool has_wish() const { return has_wish_; }
  // What the outputs shall be; they are that from now on.
  std::span<const u8> take_wish(Time now);

 private:
  void put(std::size_t at, u8 value, Time when);

  IoSettings settings_;
  std::vector<u8> values_;
  std::vector<u8> wish_;
  bool has_wish_ = false;
  bool is_ready_ = false;
  bool has_data_ = false;
  Time recorded_{};
};

// Lines of the computer itself (gpio:): arrivals are levels by the lines' offsets.
class GpioPins final : public IoLines {
 public:
  explicit GpioPins(const IoSettings& settings) : IoLines(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return has_wish() ? Time{} : next_; }

 private:
  Time next_ = tims::kNever;
};

}  // namespace rack::device
