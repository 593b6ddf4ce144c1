#include "rack/data_history.h"

#include <algorithm>

namespace rack {

DataHistory::DataHistory(std::uint32_t places, std::size_t size_max)
    : stride_(size_max),
      bytes_(std::make_unique<std::byte[]>(std::max(places, 2U) * size_max)),
      entries_(std::max(places, 2U)) {}

std::span<std::byte> DataHistory::workspace() { return {&bytes_[workspace_ * stride_], stride_}; }

void DataHistory::publish(TimeStamp recorded, std::size_t size) {
  entries_[workspace_] = {recorded, workspace().first(size)};
  workspace_ = static_cast<std::uint32_t>((workspace_ + 1) % entries_.size());
  held_ = std::min<std::uint32_t>(held_ + 1, static_cast<std::uint32_t>(entries_.size()) - 1);
}

void DataHistory::clear() { held_ = 0; }

// The index, counted back from the newest, of the last data set that is not after `time`.
std::variant<std::uint32_t, DataHistory::Miss> DataHistory::not_after(
    TimeStamp time, std::chrono::milliseconds ahead) const {
  if (held_ == 0) return Miss::kEmpty;
  if (time - newest().recorded > ahead) return Miss::kTooNew;
  if (time < oldest().recorded) return Miss::kTooOld;
  std::uint32_t n = 0;
  while (n + 1 < held_ && entry(n).recorded > time) ++n;
  return n;
}

std::variant<DataHistory::Entry, DataHistory::Miss> DataHistory::nearest(
    TimeStamp time, std::chrono::milliseconds ahead) const {
  const auto found = not_after(time, ahead);
  if (const auto* miss = std::get_if<Miss>(&found)) return *miss;
  const std::uint32_t n = std::get<std::uint32_t>(found);
  if (n == 0) return newest();
  const Entry& before = entry(n);
  const Entry& after = entry(n - 1);
  return after.recorded - time <= time - before.recorded ? after : before;
}

std::variant<DataHistory::Pair, DataHistory::Miss> DataHistory::around(
    TimeStamp time, std::chrono::milliseconds ahead) const {
  const auto found = not_after(time, ahead);
  if (const auto* miss = std::get_if<Miss>(&found)) return *miss;
  const std::uint32_t n = std::get<std::uint32_t>(found);
  if (n > 0) return Pair{entry(n), entry(n - 1)};
  return Pair{entry(std::min(1U, held_ - 1)), newest()};
}

}  // namespace rack
