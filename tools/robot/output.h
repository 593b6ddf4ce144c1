// The output of a program: read in bounded pieces, split into lines, and cut when it is a flood.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/rate_limiter.h"
#include "os/file.h"
#include "tims/time.h"

namespace timsctl::robot {

// --- Output line by line. Pure

inline constexpr std::size_t kLineMax = 4096;  // a longer line is split

class LineBuffer {
 public:
  // Returns the completed lines without their terminators.
  std::vector<std::string> add(std::string_view text);
  // Returns the incomplete last line.
  std::string take_rest() { return std::exchange(rest_, {}); }

 private:
  std::string rest_;
};

// --- Cuts and counts a flood of lines. Pure
//
// A crash report or a list of parameters passes as a whole; a program that prints without end is
// cut until it prints at a normal rate again, and the number of its lines is reported.

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

// --- The pipe of a program

// At most this much is read in one turn of the supervisor. After a turn with so much, the pipe
// rests: a program that prints faster waits in its write.
inline constexpr std::size_t kReadPerTurn = 16 << 10;
inline constexpr tims::Duration kReadPause = std::chrono::milliseconds(20);

class ProgramOutput {
 public:
  ProgramOutput() = default;
  // `pipe`: its reading end.
  explicit ProgramOutput(tims::os::File pipe);

  // Appends the lines that have arrived and pass the gate.
  void read(tims::Time now, FloodGate& gate, std::vector<std::string>& lines);
  // To be watched for input; -1: it is closed, or rests until rests_until().
  [[nodiscard]] int descriptor(tims::Time now) const;
  [[nodiscard]] tims::Time rests_until() const { return pipe_ ? rests_until_ : tims::kNever; }

 private:
  void take(std::string_view text, tims::Time now, FloodGate& gate,
            std::vector<std::string>& lines);

  tims::os::File pipe_;
  LineBuffer buffer_;
  tims::Time rests_until_{};
};

}  // namespace timsctl::robot
