#include "heading.h"

#include <charconv>
#include <numbers>
#include <span>
#include <utility>

namespace heading {

bool decode_heading(std::string_view line, rack::CompassData& data) {
  if (line.ends_with('\r')) line.remove_suffix(1);
  double degrees = 0;
  const char* const end = line.data() + line.size();
  const auto [behind, error] = std::from_chars(line.data(), end, degrees);
  if (error != std::errc() || behind != end || !(degrees >= 0 && degrees < 360)) return false;
  data.orientation = static_cast<rack::f32>(degrees * std::numbers::pi / 180);
  data.varOrientation = static_cast<rack::f32>(std::numbers::pi / 180);
  return true;
}

void Heading::start(Time now, Output& out) {
  buffer_.clear();
  has_data_ = false;
  timer_.wait_until(now);
  on_timeout(now, out);
}

void Heading::on_timeout(Time now, Output& out) {
  constexpr std::string_view kQuestion = "?\n";
  if (!timer_.take_due(now)) return;
  out.send(std::as_bytes(std::span(kQuestion)));
  timer_.wait_until(now + period_);
}

void Heading::on_arrival(const Arrival& arrival, Output&) {
  buffer_.add(arrival);
  for (;;) {
    const auto bytes = buffer_.bytes();
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return;
    if (decode_heading(text.substr(0, end), data_)) {
      has_data_ = true;
      recorded_ = buffer_.time_of(0);  // when its first byte began to arrive
    }
    buffer_.consume(end + 1);
  }
}

bool Heading::take(rack::CompassData& data, Time& recorded) {
  if (!std::exchange(has_data_, false)) return false;
  data = data_;
  recorded = recorded_;
  return true;
}

}  // namespace heading
