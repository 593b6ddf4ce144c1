#include "components/recordings/capture_statistics.h"

#include <algorithm>
#include <array>

namespace rack::device {
namespace {

constexpr Duration kGapMin = std::chrono::milliseconds(100);
constexpr std::int64_t kGapFactor = 10;

void add_to(CaptureStatistics::Sum& sum, const CaptureRecord& record) {
  ++sum.records;
  sum.bytes += record.bytes.size();
}

}  // namespace

void CaptureStatistics::add(const CaptureRecord& record) {
  constexpr std::array kOfDrivers = {Direction::kStarted, Direction::kTime, Direction::kMade};
  if (std::ranges::find(kOfDrivers, record.direction) != kOfDrivers.end()) return;
  if (!first_) first_ = last_ = record.time;
  if (record.time < last_) ++backwards_;
  last_ = std::max(last_, record.time);
  switch (record.direction) {
    case Direction::kReceived:
      return add_received(record);
    case Direction::kSent:
      return add_to(sent_, record);
    case Direction::kEvent:
      ++event_count_;
      if (events_.size() < kEventsMax)
        events_.push_back({.time = record.time - *first_, .text = record.event});
      return;
    default:
      return;  // records of drivers, ignored above
  }
}

void CaptureStatistics::add_received(const CaptureRecord& record) {
  if (last_received_) {
    const Duration gap = std::max(Duration(0), record.time - *last_received_);
    const auto before = static_cast<std::int64_t>(received_.records) - 1;
    const bool is_long =
        gap >= kGapMin && before > 0 && gap * before > between_received_ * kGapFactor;
    if (is_long) ++gaps_;
    between_received_ += gap;
    if (gap > longest_gap_) {
      longest_gap_ = gap;
      longest_gap_at_ = *last_received_ - *first_;
    }
  }
  last_received_ = record.time;
  add_to(received_, record);
  if (record.id == 0) return;
  if (by_id_.size() < kIdsMax || by_id_.contains(record.id)) add_to(by_id_[record.id], record);
}

}  // namespace rack::device
