// Interface of the dialogues of program Io, for inputs and outputs of any device.
//
// Values are bytes: 0 or 1 for each input, then 0 or 1 for each output, then 0 to 255 for each
// analog input, each in the order of the settings.
#pragma once

#include <optional>
#include <vector>

#include "rack/devices/dialogue.h"
#include "rack/proxies/io.h"

namespace rack::device {

struct IoLayout {
  std::vector<std::uint16_t> inputs{};  // pin numbers or line offsets
  std::vector<std::uint16_t> outputs{};
  std::vector<std::uint16_t> analogs{};
  bool pull_up = false;  // open inputs read as high
};

struct IoSettings {
  IoLayout layout{};
  Duration period = std::chrono::milliseconds(100);  // maximum; changes are published at once
  bool only_listen = false;                          // the device is a recording
};

class IoLines : public Dialogue {
 public:
  // Sets the outputs, in the order of the settings; sent at the next on_timeout(), which is due at
  // once.
  void set(std::span<const u8> outputs);
  [[nodiscard]] bool is_ready() const { return is_ready_; }
  bool take(IoData& data, Time& recorded);

 protected:
  explicit IoLines(const IoSettings& settings);

  [[nodiscard]] const IoSettings& settings() const { return settings_; }
  // Index of a pin in `pins`.
  static std::optional<std::size_t> index_of(const std::vector<std::uint16_t>& pins,
                                             std::uint32_t pin);
  void set_ready(bool ready) { is_ready_ = ready; }
  void reset();
  void on_input(std::size_t index, bool high, Time when);
  void on_output(std::size_t index, bool high, Time when);
  void on_analog(std::size_t index, u8 value, Time when);
  // Publishes the current values, even if unchanged.
  void publish(Time when);
  [[nodiscard]] bool has_pending() const { return has_pending_; }
  // Returns the requested outputs and takes them over as the current ones.
  std::span<const u8> take_pending(Time now);

 private:
  void put(std::size_t at, u8 value, Time when);

  IoSettings settings_;
  std::vector<u8> values_;
  std::vector<u8> pending_;
  bool has_pending_ = false;
  bool is_ready_ = false;
  bool has_data_ = false;
  Time recorded_{};
};

// Lines of the computer (gpio:): the id of an arrival is the line's offset, the byte its level.
class GpioPins final : public IoLines {
 public:
  explicit GpioPins(const IoSettings& settings) : IoLines(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return has_pending() ? Time{} : next_; }

 private:
  Time next_ = tims::kNever;
};

}  // namespace rack::device
