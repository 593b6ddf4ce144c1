// What a run of Dora has to show, and whether it did: a row for each thing that was wanted. Pure.
//
// A period is measured where its messages arrive: the mean of all gaps between them against the
// nominal one, and how far a single gap is off, of a thousand gaps the worst but one. A machine
// that wakes nobody in time cannot show this whatever runs on it; so the same run measures how late
// a timer of the highest priority wakes (as cyclictest does). What is missed only because that is
// already half of what is allowed is told apart from a failure of the robot.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tims/time.h"

namespace rack::dora {

using tims::Duration;
using tims::Time;

inline double milliseconds(Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

enum class Verdict : std::uint8_t {
  kHeld,
  kFailed,
  kMachine,  // not held, but this machine's timers alone are too late for it
  kLeftOut,  // not measured: `measured` says why
};

struct Row {
  std::string check{};   // "a"
  std::string what{};    // "period of Scan2d(1/0)"
  std::string wanted{};  // "13.33 ms, mean 0.1 %, p99.9 5 %"
  std::string measured{};
  Verdict verdict = Verdict::kLeftOut;
  std::string look{};  // what to look at when it was not held
};

// How late a timer wakes, or how uneven a terminal is, us.
struct TimerQuality {
  std::string source{};  // "cyclictest", "timer loop", "a bare terminal"
  double p99 = 0;
  double p999 = 0;
  double max = 0;
  std::uint64_t wakeups = 0;
  bool real_time = false;  // it had a real-time priority
};
// What this machine does without a robot, meanwhile.
struct Reference {
  TimerQuality timer;
  TimerQuality terminal;
};

// --- (a)

struct PeriodWish {
  std::string name;      // of the component
  double period_ms = 0;  // nominal
  double mean_error = 0.001;
  double gap_error = 0.05;   // p99.9
  bool from_a_line = false;  // each follows what came over a serial line
};
// Of the times at which its messages arrived, in order. `lost`: the gaps in it that somebody made
// on purpose are not in it: it is one span or several.
Row judge_period(const PeriodWish& wish, std::span<const std::vector<Time>> spans,
                 const Reference& reference);

// --- how long something takes

struct LatencyWish {
  std::string check;
  std::string what;
  std::string look;
  double p99_ms = 0;  // 0: none
  double max_ms = 0;
};
Row judge_latency(const LatencyWish& wish, std::span<const double> ms, const TimerQuality& timer);

// --- an amount that may not be more, its quantile

struct AmountWish {
  std::string check;
  std::string what;
  std::string look;
  std::string unit;
  double part = 0.95;
  double most = 0;
  int digits = 2;
};
Row judge_amount(const AmountWish& wish, std::span<const double> values);

// Something that is counted and must not happen, or is so or not.
Row judge_fact(std::string check, std::string what, std::string wanted, std::string measured,
               bool held, std::string look);
Row left_out(std::string check, std::string what, std::string why);

// --- all of it

// 0: all of what was measured held, and nothing was left out but what `--for` has no room for; 1:
// something failed; 3: what did not hold is the machine's.
int exit_status(std::span<const Row> rows);
std::string table(std::span<const Row> rows, const Reference& reference, bool colour);
std::string to_json(std::span<const Row> rows, const Reference& reference);
std::string_view name(Verdict verdict);

// --- the timer

// Late wake-ups, us, as a histogram of whole microseconds; the last bin holds what is beyond.
class WakeupHistogram {
 public:
  static constexpr std::size_t kBins = 20000;
  WakeupHistogram() : bins_(kBins) {}
  void add(double us, std::uint64_t count = 1);
  [[nodiscard]] TimerQuality quality(std::string source, bool real_time) const;

 private:
  std::vector<std::uint64_t> bins_;
  std::uint64_t count_ = 0;
  double max_ = 0;
};
// What `cyclictest -q -h N` prints. Nothing: it has measured nothing.
std::optional<TimerQuality> parse_cyclictest(std::string_view text);

}  // namespace rack::dora
