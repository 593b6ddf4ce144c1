#include "router/link/range_set.h"

#include <algorithm>

namespace tims::link {

std::size_t RangeSet::first_ending_at_or_after(std::uint64_t offset) const {
  // Most often it is the last one.
  if (!ranges_.empty() && ranges_.back().begin <= offset) {
    return ranges_.back().end >= offset ? ranges_.size() - 1 : ranges_.size();
  }
  const auto found = std::ranges::lower_bound(ranges_, offset, {}, &Range::end);
  return static_cast<std::size_t>(found - ranges_.begin());
}

bool RangeSet::add(Range range) {
  if (range.begin >= range.end) return true;
  const std::size_t first = first_ending_at_or_after(range.begin);
  std::size_t last = first;  // one behind those that `range` touches
  while (last < ranges_.size() && ranges_[last].begin <= range.end) {
    range.begin = std::min(range.begin, ranges_[last].begin);
    range.end = std::max(range.end, ranges_[last].end);
    ++last;
  }
  const auto at = ranges_.begin() + static_cast<std::ptrdiff_t>(first);
  if (first == last) {
    if (ranges_.size() >= kRangesMax) return false;
    ranges_.insert(at, range);
    return true;
  }
  *at = range;
  ranges_.erase(at + 1, ranges_.begin() + static_cast<std::ptrdiff_t>(last));
  return true;
}

void RangeSet::remove(Range range) {
  std::size_t i = first_ending_at_or_after(range.begin);
  while (i < ranges_.size() && ranges_[i].begin < range.end) {
    const Range old = ranges_[i];
    if (old.end <= range.begin) {
      ++i;
      continue;
    }
    const Range left{old.begin, std::max(old.begin, range.begin)};
    const Range right{std::min(old.end, range.end), old.end};
    const auto at = ranges_.begin() + static_cast<std::ptrdiff_t>(i);
    if (left.size() > 0 && right.size() > 0) {
      *at = left;
      ranges_.insert(at + 1, right);
      return;
    }
    if (left.size() == 0 && right.size() == 0) {
      ranges_.erase(at);
    } else {
      *at = left.size() > 0 ? left : right;
      ++i;
    }
  }
}

void RangeSet::remove_below(std::uint64_t offset) {
  const auto keep = std::ranges::upper_bound(ranges_, offset, {}, &Range::end);
  ranges_.erase(ranges_.begin(), keep);
  if (!ranges_.empty()) ranges_.front().begin = std::max(ranges_.front().begin, offset);
}

bool RangeSet::contains(Range range) const {
  if (range.begin >= range.end) return true;
  const std::size_t i = first_ending_at_or_after(range.begin + 1);
  return i < ranges_.size() && ranges_[i].begin <= range.begin && ranges_[i].end >= range.end;
}

std::optional<Range> RangeSet::first_missing(Range range) const {
  for (const Range& have : ranges_) {
    if (have.end <= range.begin) continue;
    if (have.begin > range.begin) {
      range.end = std::min(range.end, have.begin);
      break;
    }
    range.begin = have.end;
    if (range.begin >= range.end) return std::nullopt;
  }
  if (range.begin >= range.end) return std::nullopt;
  return range;
}

}  // namespace tims::link
