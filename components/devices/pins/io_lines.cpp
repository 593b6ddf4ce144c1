#include "components/devices/pins/io_lines.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

namespace rack::device {

IoLines::IoLines(const IoSettings& settings)
    : settings_(settings),
      values_(settings.layout.inputs.size() + settings.layout.outputs.size() +
              settings.layout.analogs.size()) {}

void IoLines::reset() {
  clear_failure();
  std::ranges::fill(values_, u8{0});
  has_pending_ = has_data_ = false;
  is_ready_ = settings_.only_listen;
}

std::optional<std::size_t> IoLines::index_of(const std::vector<std::uint16_t>& pins,
                                             std::uint32_t pin) {
  const auto found = std::ranges::find(pins, pin);
  if (found == pins.end()) return std::nullopt;
  return static_cast<std::size_t>(found - pins.begin());
}

void IoLines::set(std::span<const u8> outputs) {
  pending_.assign(outputs.begin(), outputs.end());
  pending_.resize(settings_.layout.outputs.size());
  has_pending_ = true;
}

std::span<const u8> IoLines::take_pending(Time now) {
  has_pending_ = false;
  for (std::size_t i = 0; i < pending_.size(); ++i) on_output(i, pending_[i] != 0, now);
  publish(now);
  return pending_;
}

void IoLines::put(std::size_t at, u8 value, Time when) {
  if (values_[at] == value) return;
  values_[at] = value;
  publish(when);
}

void IoLines::on_input(std::size_t index, bool high, Time when) { put(index, high ? 1 : 0, when); }
void IoLines::on_output(std::size_t index, bool high, Time when) {
  put(settings_.layout.inputs.size() + index, high ? 1 : 0, when);
}
void IoLines::on_analog(std::size_t index, u8 value, Time when) {
  put(settings_.layout.inputs.size() + settings_.layout.outputs.size() + index, value, when);
}

void IoLines::publish(Time when) {
  recorded_ = when;
  has_data_ = is_ready_;
}

bool IoLines::take(IoData& data, Time& recorded) {
  if (!std::exchange(has_data_, false)) return false;
  data.values.assign(values_.begin(), values_.end());
  recorded = recorded_;
  return true;
}

void GpioPins::start(Time now, Output&) {
  reset();
  set_ready(true);
  next_ = now;
}

void GpioPins::on_arrival(const Arrival& arrival, Output&) {
  if (arrival.bytes.size() != 1) return;
  const bool is_high = arrival.bytes.front() != std::byte{0};
  if (const auto input = index_of(settings().layout.inputs, arrival.id))
    on_input(*input, is_high, arrival.last);
  else if (const auto output = index_of(settings().layout.outputs, arrival.id))
    on_output(*output, is_high, arrival.last);
}

void GpioPins::on_timeout(Time now, Output& out) {
  if (has_pending()) {
    const auto pending = take_pending(now);
    for (std::size_t i = 0; i < pending.size(); ++i) {
      const std::array level = {pending[i] != 0 ? std::byte{1} : std::byte{0}};
      out.send(level, settings().layout.outputs[i]);
    }
  }
  if (next_ > now) return;
  publish(now);
  next_ = now + settings().period;
}

}  // namespace rack::device
