#include "tools/timsctl/rates.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/measure.h"
#include "base/text.h"
#include "base/wall_time.h"

namespace timsctl {

void RateMeter::on_message(tims::Time now, std::uint32_t body_bytes, std::uint8_t seq_nr) {
  ++window_.messages;
  window_.bytes += body_bytes;
  window_.body_min = std::min(window_.body_min, body_bytes);
  window_.body_max = std::max(window_.body_max, body_bytes);
  if (last_message_) {
    on_interval(tims::base::seconds(now - *last_message_));
    on_sequence(seq_nr);
  }
  last_message_ = now;
  last_seq_nr_ = seq_nr;
  ++total_;
}

void RateMeter::on_interval(double value) {
  Intervals& i = intervals_;
  i.min = i.count == 0 ? value : std::min(i.min, value);
  i.max = std::max(i.max, value);
  ++i.count;
  i.sum += value;
  const double before = value - i.mean;
  i.mean += before / static_cast<double>(i.count);
  i.square_sum += before * (value - i.mean);
  if (previous_interval_) i.jitter_sum += std::abs(value - *previous_interval_);
  previous_interval_ = value;
}

// A component's data carries the number of the request: always the same. Only who counts can
// lose.
void RateMeter::on_sequence(std::uint8_t seq_nr) {
  const auto step = static_cast<std::uint8_t>(seq_nr - last_seq_nr_);
  if (step == 0) return;
  counts_ = true;
  lost_ += step - 1U;
}

RateReport RateMeter::report(tims::Time now) {
  RateReport report{.messages = window_.messages, .messages_total = total_};
  const double elapsed = tims::base::seconds(now - window_begin_);
  if (window_.messages > 0) {
    report.body_min_bytes = window_.body_min;
    report.body_max_bytes = window_.body_max;
    report.body_mean_bytes =
        static_cast<double>(window_.bytes) / static_cast<double>(window_.messages);
    if (elapsed > 0) report.bytes_per_s = static_cast<double>(window_.bytes) / elapsed;
  }
  if (intervals_.count > 0 && intervals_.sum > 0) {
    const auto count = static_cast<double>(intervals_.count);
    last_intervals_ = {.rate_hz = count / intervals_.sum,
                       .min_s = intervals_.min,
                       .max_s = intervals_.max,
                       .std_s = std::sqrt(intervals_.square_sum / count),
                       .jitter_s = intervals_.jitter_sum / count};
    intervals_ = {};
  }
  report.intervals = last_intervals_;
  if (counts_) report.lost = lost_;
  if (last_message_) report.silent_s = tims::base::seconds(now - *last_message_);
  // Silent for longer than ten of its intervals: it has stopped, and has no rate.
  const bool silent = report.messages == 0 && report.silent_s > 1.0;
  if (silent && report.intervals && *report.silent_s * report.intervals->rate_hz > 10) {
    report.intervals.reset();
    last_intervals_.reset();
  }
  window_ = {};
  window_begin_ = now;
  return report;
}

json::array TopRates::update(tims::Time now, std::span<const json::value> clients,
                             std::span<const json::value> mailboxes) {
  std::map<std::int64_t, double> taken;
  for (const json::value& value : mailboxes) {
    const json::object& mailbox = value.as_object();
    taken[static_cast<std::int64_t>(number_or_zero(mailbox, "owner.client"))] +=
        number_or_zero(mailbox, "received");
  }
  const double elapsed = std::chrono::duration<double>(now - last_).count();
  std::map<std::int64_t, Sample> samples;
  json::array items;
  for (const json::value& value : clients) {
    json::object item = value.as_object();
    const auto id = static_cast<std::int64_t>(number_or_zero(item, "id"));
    const Sample sample{.in = number_or_zero(item, "in_messages"),
                        .out = number_or_zero(item, "out_messages"),
                        .in_bytes = number_or_zero(item, "in_bytes"),
                        .out_bytes = number_or_zero(item, "out_bytes"),
                        .taken = taken[id]};
    samples[id] = sample;
    const auto before = samples_.find(id);
    if (before != samples_.end() && elapsed > 0) {
      // Counters of a mailbox go with it.
      const auto rate = [&](double Sample::*field) {
        return std::max(0.0, (sample.*field - before->second.*field) / elapsed);
      };
      item["in_per_s"] = rate(&Sample::in);
      item["out_per_s"] = rate(&Sample::out);
      item["in_bytes_per_s"] = rate(&Sample::in_bytes);
      item["out_bytes_per_s"] = rate(&Sample::out_bytes);
      item["taken_per_s"] = rate(&Sample::taken);
    }
    items.push_back(std::move(item));
  }
  samples_ = std::move(samples);
  last_ = now;
  return items;
}

}  // namespace timsctl
