#include "tools/evaluation/dora/reference.h"

#include <array>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <filesystem>

#include <fcntl.h>
#include <fmt/format.h>
#include <termios.h>
#include <unistd.h>

#include "os/clock.h"
#include "tools/cli/failure.h"

namespace rack::dora {
namespace {

using namespace std::chrono_literals;

constexpr int kTimerPriority = 80;
constexpr Duration kTimerPeriod = 1ms;
constexpr Duration kReferencePatience = 5s;
constexpr int kWrites = 60;  // the priority of World in deploy/robots/dora-base.toml
constexpr int kReads = 30;   // the priority of the laser driver
constexpr Duration kBytePeriod = 13'333us;

double microseconds(Duration duration) {
  return std::chrono::duration<double, std::micro>(duration).count();
}

void sleep_until(Time time) {
  const timespec until = tims::os::to_timespec(time);
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) != 0) continue;
}

}  // namespace

bool start_thread(Thread& thread, const std::string& name, int priority,
                  const std::function<void()>& body) {
  if (thread.start({.name = name, .priority = priority}, body)) return true;
  timsctl::value_or_fail(thread.start({.name = name}, body), "cannot start a thread");
  return false;
}

// --- a timer

ReferenceTimer::ReferenceTimer()
    : log_(std::filesystem::temp_directory_path() / fmt::format("rack-dora.{}", ::getpid())) {
  try {
    cyclictest_.emplace(
        timsctl::start({.command = {"cyclictest", "-q", "-p", std::to_string(kTimerPriority), "-i",
                                    "1000", "-h", std::to_string(WakeupHistogram::kBins - 1)},
                        .log = log_}));
    if (!cyclictest_->has_ended(200ms)) return;
    (void)cyclictest_->reap();
    cyclictest_.reset();
  } catch (const timsctl::Failure&) {
    cyclictest_.reset();  // it is not installed
  }
  real_time_ = start_thread(thread_, "timer", kTimerPriority, [this] { measure(); });
}

ReferenceTimer::~ReferenceTimer() {
  ending_ = true;
  thread_.join();
  if (cyclictest_) {
    cyclictest_->signal_group(SIGKILL);
    (void)cyclictest_->has_ended(kReferencePatience);
  }
  std::error_code ignored;
  std::filesystem::remove(log_, ignored);
}

void ReferenceTimer::measure() {
  for (Time next = tims::os::now() + kTimerPeriod; !ending_; next += kTimerPeriod) {
    sleep_until(next);
    const Time now = tims::os::now();
    histogram_.add(microseconds(now - next));
    next = std::max(next, now - kTimerPeriod);
  }
}

TimerQuality ReferenceTimer::end() {
  if (cyclictest_) {
    cyclictest_->signal(SIGINT);
    if (cyclictest_->has_ended(kReferencePatience)) (void)cyclictest_->reap();
    cyclictest_.reset();
    const auto output = tims::os::read_file(log_);
    if (const auto quality = output ? parse_cyclictest(*output) : std::nullopt) return *quality;
  }
  ending_ = true;
  thread_.join();
  return histogram_.quality("timer loop", real_time_);
}

// --- a terminal

ReferenceTerminal::ReferenceTerminal() : device_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
  std::array<char, 64> name{};
  if (device_ && ::grantpt(device_.get()) == 0 && ::unlockpt(device_.get()) == 0 &&
      ::ptsname_r(device_.get(), name.data(), name.size()) == 0)
    line_ = tims::os::File(::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  termios settings{};
  if (!line_ || ::tcgetattr(line_.get(), &settings) != 0)
    throw timsctl::Failure(timsctl::Exit::kDenied, "no_terminal",
                           "cannot create a pseudo-terminal");
  ::cfmakeraw(&settings);
  (void)::tcsetattr(line_.get(), TCSANOW, &settings);
  real_time_ = start_thread(reader_, "terminal", kReads, [this] { read(); });
  start_thread(writer_, "terminal's end", kWrites, [this] { write(); });
}

ReferenceTerminal::~ReferenceTerminal() { (void)end(); }

// Writes until end(). The last byte wakes the reader, so that it sees ending_.
void ReferenceTerminal::write() {
  constexpr char kByte = 0;
  Time next = tims::os::now();
  do {
    next += kBytePeriod;
    sleep_until(next);
    if (::write(device_.get(), &kByte, 1) != 1) return;
  } while (!ending_);
}

void ReferenceTerminal::read() {
  std::optional<Time> before;
  char byte = 0;
  while (!ending_ && ::read(line_.get(), &byte, 1) == 1) {
    const Time now = tims::os::now();
    if (before) histogram_.add(std::abs(microseconds(now - *before - kBytePeriod)));
    before = now;
  }
}

TimerQuality ReferenceTerminal::end() {
  ending_ = true;
  writer_.join();
  reader_.join();
  return histogram_.quality("pseudo-terminal", real_time_);
}

}  // namespace rack::dora
