// A compass that answers "?" with degrees: "271.5", clockwise from north, and a line end. 9600
// baud.
#pragma once

#include <string_view>

#include <rack/devices/dialogue.h>
#include <rack/devices/stream_buffer.h>
#include <rack/proxies/compass.h>

namespace heading {

using rack::device::Arrival;
using rack::device::Output;
using tims::Duration;
using tims::Time;

// "271.5"; false: not a valid heading.
bool decode_heading(std::string_view line, rack::CompassData& data);

class Heading final : public rack::device::Dialogue {
 public:
  explicit Heading(Duration period) : period_(period) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;

  // The device is initialised: from now on, three periods without data are an error.
  [[nodiscard]] bool is_ready() const { return true; }
  // True if there are new data; `recorded`: time of the measurement.
  bool take(rack::CompassData& data, Time& recorded);

 private:
  static constexpr std::size_t kLineMax = 16;

  Duration period_;
  rack::device::StreamBuffer buffer_{2 * kLineMax};
  rack::CompassData data_{};
  Time recorded_{};
  bool has_data_ = false;
};

}  // namespace heading
