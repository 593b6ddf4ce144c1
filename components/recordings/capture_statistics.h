// Statistics of a recording: records and bytes per direction and id, events, gaps.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "rack/devices/capture.h"

namespace rack::device {

class CaptureStatistics {
 public:
  struct Sum {
    std::uint64_t records = 0;
    std::uint64_t bytes = 0;
  };
  struct Event {
    Duration time{};  // all times in this class are relative to the first record
    std::string text;
  };

  void add(const CaptureRecord& record);

  [[nodiscard]] const Sum& received() const { return received_; }
  [[nodiscard]] const Sum& sent() const { return sent_; }
  [[nodiscard]] Duration duration() const { return last_ - first_.value_or(last_); }
  // Received CAN frames and datagrams by id, at most kIdsMax different ids.
  [[nodiscard]] const std::map<std::uint32_t, Sum>& by_id() const { return by_id_; }
  // The first kEventsMax events, and the number of all events.
  [[nodiscard]] const std::vector<Event>& events() const { return events_; }
  [[nodiscard]] std::uint64_t event_count() const { return event_count_; }

  // The longest time without a received record, and when it began.
  [[nodiscard]] Duration longest_gap() const { return longest_gap_; }
  [[nodiscard]] Duration longest_gap_at() const { return longest_gap_at_; }
  // Number of gaps between received records that are at least 10 times as long as the mean interval
  // and at least 100 ms.
  [[nodiscard]] std::uint64_t gaps() const { return gaps_; }
  // Number of records whose time is before that of their predecessor.
  [[nodiscard]] std::uint64_t backwards() const { return backwards_; }

  static constexpr std::size_t kIdsMax = 4096;
  static constexpr std::size_t kEventsMax = 100;

 private:
  void add_received(const CaptureRecord& record);

  Sum received_;
  Sum sent_;
  std::map<std::uint32_t, Sum> by_id_;
  std::vector<Event> events_;
  std::uint64_t event_count_ = 0;
  std::optional<Duration> first_;
  Duration last_{};
  std::optional<Duration> last_received_;
  Duration between_received_{};  // sum of all intervals
  Duration longest_gap_{};
  Duration longest_gap_at_{};
  std::uint64_t gaps_ = 0;
  std::uint64_t backwards_ = 0;
};

}  // namespace rack::device
