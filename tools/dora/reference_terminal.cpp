#include "tools/dora/reference_terminal.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <optional>

#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include "os/clock.h"
#include "tools/cli/failure.h"

namespace rack::dora {
namespace {

constexpr int kWrites = 60;  // as deploy/worlds/dora.toml's World
constexpr int kReads = 30;   // as the driver of her laser
constexpr Duration kPeriod = std::chrono::microseconds(13'333);

}  // namespace

ReferenceTerminal::ReferenceTerminal() : device_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
  std::array<char, 64> name{};
  if (device_ && ::grantpt(device_.get()) == 0 && ::unlockpt(device_.get()) == 0 &&
      ::ptsname_r(device_.get(), name.data(), name.size()) == 0)
    line_ = tims::os::File(::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  termios settings{};
  if (!line_ || ::tcgetattr(line_.get(), &settings) != 0)
    throw timsctl::Failure(timsctl::Exit::kDenied, "no_terminal", "no terminal can be made here");
  ::cfmakeraw(&settings);
  (void)::tcsetattr(line_.get(), TCSANOW, &settings);
  const auto start = [](Thread& thread, const char* what, int priority, const auto& body) {
    if (thread.start({.name = what, .priority = priority}, body)) return true;
    timsctl::value_or_fail(thread.start({.name = what}, body), "a thread");
    return false;
  };
  real_time_ = start(reader_, "terminal", kReads, [this] { read(); });
  start(writer_, "terminal's end", kWrites, [this] { write(); });
}

ReferenceTerminal::~ReferenceTerminal() { (void)end(); }

// Until somebody ends it; the last byte wakes the reader for that.
void ReferenceTerminal::write() {
  constexpr char kByte = 0;
  Time next = tims::os::now();
  do {
    next += kPeriod;
    const timespec until = tims::os::to_timespec(next);
    while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) != 0) continue;
    if (::write(device_.get(), &kByte, 1) != 1) return;
  } while (!ending_);
}

void ReferenceTerminal::read() {
  std::optional<Time> before;
  char byte = 0;
  while (!ending_ && ::read(line_.get(), &byte, 1) == 1) {
    const Time now = tims::os::now();
    if (before)
      histogram_.add(
          std::abs(std::chrono::duration<double, std::micro>(now - *before - kPeriod).count()));
    before = now;
  }
}

TimerQuality ReferenceTerminal::end() {
  ending_ = true;
  writer_.join();
  reader_.join();
  TimerQuality quality = histogram_.quality();
  quality.source = "a bare terminal";
  quality.real_time = real_time_;
  return quality;
}

}  // namespace rack::dora
