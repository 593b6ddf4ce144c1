#include "tools/evaluation/dora/judgement.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "base/statistics.h"
#include "base/text.h"
#include "tools/cli/output.h"

namespace rack::dora {
namespace {

using tims::base::quantile;
namespace json = timsctl::json;

// If the timer alone uses more than half of the limit, a violation is attributed to the machine.
Verdict verdict(bool held, double limit_ms, double timer_us) {
  if (held) return Verdict::kHeld;
  return 2 * timer_us / 1000 > limit_ms ? Verdict::kMachine : Verdict::kFailed;
}

}  // namespace

Row judge_period(const PeriodLimits& limits, std::span<const std::vector<Time>> spans,
                 const Reference& reference) {
  Row row{.check = "a",
          .what = "period of " + limits.name,
          .wanted = fmt::format("{:.5g} ms, mean {:g} %, p99.9 {:g} %", limits.period_ms,
                                limits.mean_error * 100, limits.gap_error * 100),
          .look = "timsctl msg hz " + limits.name + "; its log"};
  std::vector<double> errors;
  double sum = 0;
  for (const std::vector<Time>& times : spans)
    for (std::size_t i = 1; i < times.size(); ++i) {
      const double gap = milliseconds(times[i] - times[i - 1]);
      sum += gap;
      errors.push_back(std::abs(gap - limits.period_ms));
    }
  if (errors.size() < 2) {
    row.verdict = Verdict::kFailed;
    row.measured = fmt::format("{} intervals received", errors.size());
    return row;
  }
  const double mean = sum / static_cast<double>(errors.size());
  const double mean_error = mean / limits.period_ms - 1;
  const double worst = quantile(errors, 0.999) / limits.period_ms;
  row.measured = fmt::format("{:.5g} ms, mean {:+.3f} %, p99.9 {:.2f} % of {}", mean,
                             mean_error * 100, worst * 100, errors.size());
  // With few intervals, a late first or last message shifts the mean within this tolerance.
  const double ends = limits.gap_error / static_cast<double>(errors.size());
  const bool mean_held = std::abs(mean_error) <= std::max(limits.mean_error, ends);
  const TimerQuality& machine = limits.from_a_line ? reference.terminal : reference.timer;
  row.verdict = !mean_held ? Verdict::kFailed
                           : verdict(worst < limits.gap_error, limits.gap_error * limits.period_ms,
                                     machine.p999);
  return row;
}

Row judge_latency(const LatencyLimits& limits, std::span<const double> ms,
                  const TimerQuality& timer) {
  Row row{.check = limits.check, .what = limits.what, .look = limits.look};
  row.wanted = limits.p99_ms > 0
                   ? fmt::format("p99 {:g} ms, max {:g} ms", limits.p99_ms, limits.max_ms)
                   : fmt::format("{:g} ms", limits.max_ms);
  if (ms.empty()) {
    row.verdict = Verdict::kFailed;
    row.measured = "it was not observed";
    return row;
  }
  const std::vector<double> all(ms.begin(), ms.end());
  const double p99 = quantile(all, 0.99);
  const double max = quantile(all, 1);
  row.measured = ms.size() == 1 ? fmt::format("{:.1f} ms", max)
                                : fmt::format("p50 {:.1f}, p99 {:.1f}, max {:.1f} ms of {}",
                                              quantile(all, 0.5), p99, max, ms.size());
  const bool held = max <= limits.max_ms && (limits.p99_ms == 0 || p99 <= limits.p99_ms);
  row.verdict = verdict(held, limits.max_ms, timer.max);
  return row;
}

Row judge_amount(const AmountLimit& limits, std::span<const double> values) {
  Row row{.check = limits.check, .what = limits.what, .look = limits.look};
  row.wanted = fmt::format("p{:g} {:g} {}", limits.part * 100, limits.most, limits.unit);
  if (values.empty()) {
    row.verdict = Verdict::kFailed;
    row.measured = "nothing was measured";
    return row;
  }
  const std::vector<double> all(values.begin(), values.end());
  const double value = quantile(all, limits.part);
  row.measured = fmt::format("{:.{}f} {}, max {:.{}f}, of {}", value, limits.digits, limits.unit,
                             quantile(all, 1), limits.digits, all.size());
  row.verdict = value <= limits.most ? Verdict::kHeld : Verdict::kFailed;
  return row;
}

Row judge_fact(std::string check, std::string what, std::string wanted, std::string measured,
               bool held, std::string look) {
  return {.check = std::move(check),
          .what = std::move(what),
          .wanted = std::move(wanted),
          .measured = std::move(measured),
          .verdict = held ? Verdict::kHeld : Verdict::kFailed,
          .look = std::move(look)};
}

Row left_out(std::string check, std::string what, std::string why) {
  return {.check = std::move(check),
          .what = std::move(what),
          .wanted = {},
          .measured = std::move(why),
          .verdict = Verdict::kLeftOut};
}

// --- all rows

std::string_view name(Verdict verdict) {
  constexpr std::array<std::string_view, 4> kNames = {"held", "NOT HELD", "machine", "left out"};
  return kNames.at(static_cast<std::size_t>(verdict));
}

int exit_status(std::span<const Row> rows) {
  const auto any = [&](Verdict verdict) {
    return std::ranges::any_of(rows, [&](const Row& row) { return row.verdict == verdict; });
  };
  if (any(Verdict::kFailed)) return 1;
  return any(Verdict::kMachine) ? 3 : 0;
}

std::string table(std::span<const Row> rows, const Reference& reference, bool colour) {
  std::array<std::size_t, 3> widths{};
  for (const Row& row : rows) {
    widths[0] = std::max(widths[0], row.what.size());
    widths[1] = std::max(widths[1], row.wanted.size());
    widths[2] = std::max(widths[2], row.measured.size());
  }
  std::string text;
  for (const Row& row : rows) {
    const auto tone = row.verdict == Verdict::kHeld      ? timsctl::Tone::kGood
                      : row.verdict == Verdict::kFailed  ? timsctl::Tone::kBad
                      : row.verdict == Verdict::kMachine ? timsctl::Tone::kWarning
                                                         : timsctl::Tone::kDim;
    text += fmt::format("({}) {:<{}}  {:<{}}  {:<{}}  {}\n", row.check, row.what, widths[0],
                        row.wanted, widths[1], row.measured, widths[2],
                        timsctl::paint(name(row.verdict), tone, colour));
    if (row.verdict == Verdict::kFailed && !row.look.empty())
      text += fmt::format("    see: {}\n", row.look);
  }
  const auto append = [&](const TimerQuality& quality, std::string_view what) {
    text += fmt::format("{}{}: {} {:.0f} us at p99, {:.0f} at p99.9, {:.0f} at most, of {}\n",
                        quality.source, quality.real_time ? "" : " (without real-time priority)",
                        what, quality.p99, quality.p999, quality.max, quality.wakeups);
  };
  append(reference.timer, "timer latency");
  append(reference.terminal, "jitter of a byte sent 75 times a second");
  if (exit_status(rows) == 3)
    text +=
        "machine: the timers of this machine are too late for these limits; the robot may be "
        "correct\n";
  return text;
}

std::string to_json(std::span<const Row> rows, const Reference& reference) {
  const auto object_of = [](const TimerQuality& quality) {
    return json::object{{"source", quality.source},   {"real_time", quality.real_time},
                        {"wakeups", quality.wakeups}, {"p99_us", quality.p99},
                        {"p999_us", quality.p999},    {"max_us", quality.max}};
  };
  json::array items;
  for (const Row& row : rows)
    items.push_back(json::object{{"check", row.check},
                                 {"what", row.what},
                                 {"wanted", row.wanted},
                                 {"measured", row.measured},
                                 {"verdict", name(row.verdict)},
                                 {"look_at", row.look}});
  return timsctl::to_text(json::object{{"schema", "rack/dora/1"},
                                       {"held", exit_status(rows) == 0},
                                       {"timer", object_of(reference.timer)},
                                       {"terminal", object_of(reference.terminal)},
                                       {"items", std::move(items)}});
}

// --- the timer

void WakeupHistogram::add(double us, std::uint64_t count) {
  const double late = std::max(0.0, us);
  bins_[std::min(kBins - 1, static_cast<std::size_t>(late))] += count;
  count_ += count;
  if (count > 0) max_ = std::max(max_, late);
}

TimerQuality WakeupHistogram::quality(std::string source, bool real_time) const {
  const auto at = [&](double part) {
    auto left = static_cast<std::uint64_t>(std::ceil(part * static_cast<double>(count_)));
    for (std::size_t us = 0; us < kBins; ++us) {
      if (bins_[us] >= left) return us + 1 < kBins ? static_cast<double>(us) : max_;
      left -= bins_[us];
    }
    return max_;
  };
  TimerQuality quality{
      .source = std::move(source), .max = max_, .wakeups = count_, .real_time = real_time};
  if (count_ > 0) {
    quality.p99 = at(0.99);
    quality.p999 = at(0.999);
  }
  return quality;
}

// The output has one line "000012 001234" (latency, count) per microsecond. The lines
// "# Max Latencies: 00123" and "# Histogram Overflows: 00002" describe values beyond the last bin.
std::optional<TimerQuality> parse_cyclictest(std::string_view text) {
  WakeupHistogram histogram;
  std::uint64_t max = 0;
  std::uint64_t beyond = 0;
  const auto after = [](std::string_view line, std::string_view prefix, std::uint64_t& number) {
    if (!line.starts_with(prefix)) return;
    line.remove_prefix(std::min(line.size(), line.find_first_not_of(' ', prefix.size())));
    std::from_chars(line.data(), line.data() + line.size(), number);
  };
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(text.size(), end + 1));
    after(line, "# Max Latencies:", max);
    after(line, "# Histogram Overflows:", beyond);
    const std::size_t between = line.find(' ');
    const auto us = tims::base::parse_number<std::uint64_t>(line.substr(0, between));
    if (!us || between == std::string_view::npos) continue;
    const auto count = tims::base::parse_number<std::uint64_t>(line.substr(between + 1));
    if (count) histogram.add(static_cast<double>(*us), *count);
  }
  histogram.add(static_cast<double>(max), beyond);
  TimerQuality quality = histogram.quality("cyclictest", true);
  if (quality.wakeups == 0) return {};
  return quality;
}

}  // namespace rack::dora
