// Judges a run of Dora: one row per requirement, with the measured value and a verdict. Pure.
//
// A period is measured at the receiver: the mean interval between messages is compared with the
// nominal period, and so is the 99.9th percentile of the deviation of single intervals. A machine
// with late timers cannot meet these limits, whatever runs on it. Therefore the same run measures
// the wake-up latency of a timer of the highest priority (as cyclictest does). If this latency
// alone exceeds half of a limit, a violation of the limit is attributed to the machine, not to the
// robot.
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
  kMachine,  // not held, but the latency of this machine's timers exceeds half of the limit
  kLeftOut,  // not measured; `measured` states the reason
};

struct Row {
  std::string check{};   // "a"
  std::string what{};    // "period of Scan2d(1/0)"
  std::string wanted{};  // "13.33 ms, mean 0.1 %, p99.9 5 %"
  std::string measured{};
  Verdict verdict = Verdict::kLeftOut;
  std::string look{};  // where to look for the cause if the verdict is not kHeld
};

// The latency of a timer, or the jitter of bytes through a pseudo-terminal, us.
struct TimerQuality {
  std::string source{};  // "cyclictest", "timer loop", "pseudo-terminal"
  double p99 = 0;
  double p999 = 0;
  double max = 0;
  std::uint64_t wakeups = 0;
  bool real_time = false;  // measured with a real-time priority
};
// The quality of this machine without a robot, measured during the run.
struct Reference {
  TimerQuality timer;
  TimerQuality terminal;
};

// --- (a) periods

struct PeriodLimits {
  std::string name;      // the component's
  double period_ms = 0;  // nominal
  double mean_error = 0.001;
  double gap_error = 0.05;   // p99.9
  bool from_a_line = false;  // each message follows input from a serial line
};
// `spans`: the arrival times of the messages, in ascending order. Deliberate interruptions separate
// two spans; the interval between two spans does not count.
Row judge_period(const PeriodLimits& limits, std::span<const std::vector<Time>> spans,
                 const Reference& reference);

// --- latencies

struct LatencyLimits {
  std::string check;
  std::string what;
  std::string look;
  double p99_ms = 0;  // 0: no limit
  double max_ms = 0;
};
Row judge_latency(const LatencyLimits& limits, std::span<const double> ms,
                  const TimerQuality& timer);

// --- a quantile of an amount, with an upper limit

struct AmountLimit {
  std::string check;
  std::string what;
  std::string look;
  std::string unit;
  double part = 0.95;
  double most = 0;
  int digits = 2;
};
Row judge_amount(const AmountLimit& limits, std::span<const double> values);

// A requirement that is met or not, without a quantile; the caller decides.
Row judge_fact(std::string check, std::string what, std::string wanted, std::string measured,
               bool held, std::string look);
Row left_out(std::string check, std::string what, std::string why);

// --- all rows

// 0: no row has failed (rows that were left out do not count); 1: a row is kFailed; 3: no row is
// kFailed, but at least one is kMachine.
int exit_status(std::span<const Row> rows);
std::string table(std::span<const Row> rows, const Reference& reference, bool colour);
std::string to_json(std::span<const Row> rows, const Reference& reference);
std::string_view name(Verdict verdict);

// --- the timer

// A histogram of wake-up latencies in bins of 1 us; the last bin counts all larger values.
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
// Parses the output of `cyclictest -q -h N`. Empty if it contains no measurement.
std::optional<TimerQuality> parse_cyclictest(std::string_view text);

}  // namespace rack::dora
