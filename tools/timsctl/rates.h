// Rate, jitter and losses of a stream of messages. Pure.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>

#include "tims/time.h"
#include "tools/cli/output.h"

namespace timsctl {

struct RateReport {
  std::uint64_t messages = 0;  // since the last report
  std::uint64_t messages_total = 0;
  double bytes_per_s = 0;  // since the last report
  std::uint32_t body_min_bytes = 0;
  double body_mean_bytes = 0;
  std::uint32_t body_max_bytes = 0;
  // Statistics of the intervals between messages; empty before the second message.
  struct Intervals {
    double rate_hz = 0;
    double min_s = 0;
    double max_s = 0;
    double std_s = 0;
    double jitter_s = 0;  // mean change from one interval to the next
  };
  std::optional<Intervals> intervals{};
  std::optional<std::uint64_t> lost{};  // by sequence numbers, if the sender counts
  std::optional<double> silent_s{};     // since the last message
};

class RateMeter {
 public:
  explicit RateMeter(tims::Time now) : window_begin_(now) {}

  void on_message(tims::Time now, std::uint32_t body_bytes, std::uint8_t seq_nr);
  // The statistics since the last report. If there was no message, the previous intervals are kept.
  RateReport report(tims::Time now);

 private:
  struct Window {
    std::uint64_t messages = 0;
    std::uint64_t bytes = 0;
    std::uint32_t body_min = UINT32_MAX;
    std::uint32_t body_max = 0;
  };
  struct Intervals {
    std::uint64_t count = 0;
    double sum = 0;
    double mean = 0;
    double square_sum = 0;  // sum of squared deviations from the mean (Welford)
    double min = 0;
    double max = 0;
    double jitter_sum = 0;
  };
  void on_interval(double value);  // in seconds
  void on_sequence(std::uint8_t seq_nr);

  tims::Time window_begin_;
  Window window_{};
  Intervals intervals_{};
  std::optional<RateReport::Intervals> last_intervals_{};
  std::optional<double> previous_interval_{};
  std::optional<tims::Time> last_message_{};
  std::uint64_t total_ = 0;
  std::uint8_t last_seq_nr_ = 0;
  bool counts_ = false;  // the sequence numbers change
  std::uint64_t lost_ = 0;
};

// Rates of each client from two samples of its counters. Pure.

class TopRates {
 public:
  // Adds in_per_s, out_per_s, in_bytes_per_s, out_bytes_per_s and taken_per_s (messages taken from
  // its mailboxes, including those that bypassed the router) to each client. A new client has no
  // rates.
  json::array update(tims::Time now, std::span<const json::value> clients,
                     std::span<const json::value> mailboxes);

 private:
  struct Sample {
    double in = 0;
    double out = 0;
    double in_bytes = 0;
    double out_bytes = 0;
    double taken = 0;
  };
  tims::Time last_{};
  std::map<std::int64_t, Sample> samples_;  // by client
};

}  // namespace timsctl
