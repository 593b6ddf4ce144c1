#include "router/io/service.h"

#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <system_error>

#include <boost/asio/io_context.hpp>
#include <fmt/core.h>
#include <linux/capability.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "os/clock.h"
#include "os/environment.h"

namespace tims::io {
namespace {

long long number_in(const char* name) {
  const std::string text = os::environment(name);
  long long value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

// Half of the unit's WatchdogSec=.
std::chrono::microseconds watchdog_interval() {
  const long long pid = number_in("WATCHDOG_PID");
  if (pid != 0 && pid != ::getpid()) return {};
  return std::chrono::microseconds(number_in("WATCHDOG_USEC") / 2);
}

// With a limit, later allocations would fail.
bool may_lock_all() {
  const rlimit unlimited{RLIM_INFINITY, RLIM_INFINITY};
  if (::setrlimit(RLIMIT_MEMLOCK, &unlimited) == 0) return true;
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> sets{};
  if (::syscall(SYS_capget, &header, sets.data()) == 0 &&
      (sets[0].effective & CAP_TO_MASK(CAP_IPC_LOCK)) != 0)
    return true;
  errno = EPERM;
  return false;
}

}  // namespace

// --- Signals

Signals::Signals(Loop& loop, Actions actions)
    : actions_(std::move(actions)), signals_(loop.context(), SIGTERM, SIGINT, SIGHUP) {
  signals_.add(SIGUSR2);
  wait();
}

void Signals::wait() {
  signals_.async_wait([this](const boost::system::error_code& error, int signal) {
    if (error) return;
    wait();
    if (signal == SIGHUP) return actions_.reload();
    (signal == SIGUSR2 ? actions_.hand_over : actions_.stop)();
  });
}

// --- Service

Service::Service(Loop& loop)
    : manager_(os::ServiceManager::of_environment()), timer_(loop, [this] { feed(); }) {
  if (manager_.listens()) interval_ = watchdog_interval();
}

void Service::ready() { wait(manager_.report("READY", "1")); }

void Service::reloading() {
  const auto now =
      std::chrono::duration_cast<std::chrono::microseconds>(os::now().time_since_epoch());
  manager_.report("RELOADING", fmt::format("1\nMONOTONIC_USEC={}", now.count()));
}

void Service::stopping() { manager_.report("STOPPING", "1"); }

void Service::feed() {
  wait(interval_.count() > 0 ? manager_.report("WATCHDOG", "1") : manager_.flush());
}

// Until the watchdog must be triggered again, or until a busy manager may have room.
void Service::wait(bool reported) {
  if (!reported) return timer_.set(os::now() + os::ServiceManager::kFlushPause);
  if (interval_.count() > 0) timer_.set(os::now() + interval_);
}

Result<void> become_real_time(int priority) {
  std::string missing;
  if (!may_lock_all() || ::mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0)
    missing = fmt::format("memory is not locked: {} (LimitMEMLOCK=infinity, ulimit -l unlimited)",
                          std::generic_category().message(errno));
  const sched_param parameter{.sched_priority = priority};
  if (::sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &parameter) != 0)
    missing += fmt::format("{}no real-time priority: {} (LimitRTPRIO={}, ulimit -r {})",
                           missing.empty() ? "" : "; ", std::generic_category().message(errno),
                           priority, priority);
  if (missing.empty()) return {};
  return Error(Errc::kSystem, missing);
}

std::uint64_t resident_bytes() {
  std::uint64_t pages = 0;
  std::FILE* file = std::fopen("/proc/self/statm", "re");
  if (file == nullptr) return 0;
  if (std::fscanf(file, "%*u %lu", &pages) != 1) pages = 0;
  std::fclose(file);
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

void raise_descriptor_limit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace tims::io
