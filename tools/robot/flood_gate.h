// Cuts and counts a flood of lines. Pure.
//
// A crash report or a list of parameters passes as a whole; a program that prints without end is
// cut until it prints at a normal rate again, and the number of its lines is reported.
#pragma once

#include <cstdint>
#include <optional>

#include "base/rate_limiter.h"
#include "tims/time.h"

namespace timsctl::robot {

inline constexpr std::uint64_t kLinesPerSecond = 50;
inline constexpr std::uint64_t kLinesAtOnce = 1000;
inline constexpr tims::Duration kFloodReportEach = std::chrono::seconds(10);

class FloodGate {
 public:
  // Whether the next line passes.
  bool pass(tims::Time now) { return pass(now, 1) == 1; }
  // How many of the next `lines` lines pass, beginning with the first.
  std::uint64_t pass(tims::Time now, std::uint64_t lines);
  [[nodiscard]] bool is_cut() const { return cut_; }
  // The number of lines that did not pass, when it is to be reported.
  std::optional<std::uint64_t> take_report(tims::Time now);
  // When to call take_report(); kNever: nothing is to be reported.
  [[nodiscard]] tims::Time report_at() const;

 private:
  void measure(tims::Time now);

  tims::base::LineLimiter limiter_{kLinesPerSecond, kLinesAtOnce};
  bool cut_ = false;
  std::uint64_t held_back_ = 0;
  tims::Time reported_{};
  tims::Time cut_at_{};
  tims::Time second_{};          // start of the second in which lines are counted, while cut
  std::uint64_t in_second_ = 0;  // lines in it
};

}  // namespace timsctl::robot
