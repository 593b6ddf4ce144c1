// A set of half-open ranges of byte offsets: few of them, sorted, apart from each other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace tims::link {

struct Range {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;

  [[nodiscard]] std::uint64_t size() const { return end - begin; }
  bool operator==(const Range&) const = default;
};

class RangeSet {
 public:
  static constexpr std::size_t kRangesMax = 512;

  // False: it would be more than kRangesMax ranges, and nothing was added.
  bool add(Range range);
  void remove(Range range);
  // Everything below.
  void remove_below(std::uint64_t offset);
  void clear() { ranges_.clear(); }

  [[nodiscard]] bool empty() const { return ranges_.empty(); }
  [[nodiscard]] const std::vector<Range>& ranges() const { return ranges_; }
  [[nodiscard]] Range front() const { return ranges_.front(); }
  [[nodiscard]] bool contains(Range range) const;
  // The first part of `range` that is not in the set.
  [[nodiscard]] std::optional<Range> first_missing(Range range) const;

 private:
  [[nodiscard]] std::size_t first_ending_at_or_after(std::uint64_t offset) const;

  std::vector<Range> ranges_;
};

}  // namespace tims::link
