#include "tools/dora/reference_timer.h"

#include <csignal>
#include <ctime>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <unistd.h>

#include "os/clock.h"
#include "tools/cli/failure.h"

namespace rack::dora {
namespace {

using namespace std::chrono_literals;

constexpr int kPriority = 80;
constexpr Duration kPeriod = 1ms;
constexpr Duration kPatience = 5s;

}  // namespace

ReferenceTimer::ReferenceTimer()
    : log_(std::filesystem::temp_directory_path() / fmt::format("rack-dora.{}", ::getpid())) {
  try {
    cyclictest_.emplace(
        timsctl::start({.command = {"cyclictest", "-q", "-p", std::to_string(kPriority), "-i",
                                    "1000", "-h", std::to_string(WakeupHistogram::kBins - 1)},
                        .log = log_}));
    if (!cyclictest_->has_ended(200ms)) return;
    (void)cyclictest_->reap();
    cyclictest_.reset();
  } catch (const timsctl::Failure&) {
    cyclictest_.reset();  // it is not installed
  }
  const auto body = [this] { measure(); };
  real_time_ = thread_.start({.name = "timer", .priority = kPriority}, body).ok();
  if (!real_time_) timsctl::value_or_fail(thread_.start({.name = "timer"}, body), "a thread");
}

ReferenceTimer::~ReferenceTimer() {
  ending_ = true;
  thread_.join();
  if (cyclictest_) {
    cyclictest_->signal_group(SIGKILL);
    (void)cyclictest_->has_ended(kPatience);
  }
  std::error_code ignored;
  std::filesystem::remove(log_, ignored);
}

void ReferenceTimer::measure() {
  for (Time next = tims::os::now() + kPeriod; !ending_; next += kPeriod) {
    const timespec until = tims::os::to_timespec(next);
    while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) != 0) continue;
    const Time now = tims::os::now();
    histogram_.add(std::chrono::duration<double, std::micro>(now - next).count());
    next = std::max(next, now - kPeriod);
  }
}

TimerQuality ReferenceTimer::end() {
  if (cyclictest_) {
    cyclictest_->signal(SIGINT);
    if (cyclictest_->has_ended(kPatience)) (void)cyclictest_->reap();
    cyclictest_.reset();
    std::ifstream file(log_);
    const std::string said{std::istreambuf_iterator<char>(file), {}};
    if (const auto quality = parse_cyclictest(said)) return *quality;
  }
  ending_ = true;
  thread_.join();
  TimerQuality quality = histogram_.quality();
  quality.source = "timer loop";
  quality.real_time = real_time_;
  return quality;
}

}  // namespace rack::dora
