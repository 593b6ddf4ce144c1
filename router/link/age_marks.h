// Since when the bytes of a queue are there, to some milliseconds: marks at the beginnings of
// messages, so few that they never matter.
#pragma once

#include <cstdint>
#include <deque>

#include "tims/time.h"

namespace tims::link {

class AgeMarks {
 public:
  // A message was appended at `offset`.
  void add(std::uint64_t offset, Time now) {
    if (!marks_.empty() && now < marks_.back().at + kResolution) return;
    marks_.push_back({offset, now});
  }
  // Messages begin at the result, and all below it were appended before `limit`.
  [[nodiscard]] std::uint64_t older_than(Time limit, std::uint64_t end) const {
    for (const Mark& mark : marks_) {
      if (mark.at + kResolution > limit) return mark.offset;
    }
    return end;
  }
  // When what lies at the front was appended; `offset` is the front.
  [[nodiscard]] Time oldest(std::uint64_t offset) {
    forget_below(offset);
    return marks_.empty() ? kNever : marks_.front().at;
  }
  void forget_below(std::uint64_t offset) {
    while (marks_.size() > 1 && marks_[1].offset <= offset) marks_.pop_front();
  }
  void clear() { marks_.clear(); }

 private:
  static constexpr Duration kResolution = std::chrono::milliseconds(10);
  struct Mark {
    std::uint64_t offset;
    Time at;
  };
  std::deque<Mark> marks_;
};

}  // namespace tims::link
