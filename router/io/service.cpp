#include "router/io/service.h"

#include <charconv>
#include <csignal>
#include <cstdlib>
#include <cstring>

#include <fmt/core.h>
#include <sys/resource.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "os/clock.h"

namespace tims::io {
namespace {

sigset_t handled_signals() {
  sigset_t set;
  ::sigemptyset(&set);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) ::sigaddset(&set, signal);
  return set;
}

os::File block_and_open(const sigset_t& signals) {
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return os::File(::signalfd(-1, &signals, SFD_NONBLOCK | SFD_CLOEXEC));
}

std::string environment(const char* name) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nobody changes the environment
  const char* text = std::getenv(name);
  return text == nullptr ? "" : text;
}

long long number_in(const char* name) {
  const std::string text = environment(name);
  long long value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

// Half of what the unit's WatchdogSec= allows.
std::chrono::microseconds watchdog_interval() {
  const long long pid = number_in("WATCHDOG_PID");
  if (pid != 0 && pid != ::getpid()) return {};
  return std::chrono::microseconds(number_in("WATCHDOG_USEC") / 2);
}

}  // namespace

// --- Signals

Signals::Signals(Loop& loop, Actions actions)
    : actions_(std::move(actions)),
      file_(block_and_open(handled_signals())),
      watch_(loop, file_.get(), [this](Ready) { take(); }) {}

void Signals::take() {
  signalfd_siginfo signal{};
  while (::read(file_.get(), &signal, sizeof signal) == sizeof signal) {
    (signal.ssi_signo == SIGHUP ? actions_.reload : actions_.stop)();
  }
}

// --- ServiceManager

ServiceManager::ServiceManager(Loop& loop)
    : path_(environment("NOTIFY_SOCKET")), timer_(loop, [this] { feed(); }) {
  if (!path_.empty()) interval_ = watchdog_interval();
}

void ServiceManager::ready() {
  notify("READY=1");
  if (interval_.count() > 0) timer_.set(os::now() + interval_);
}

void ServiceManager::reloading() {
  const auto now =
      std::chrono::duration_cast<std::chrono::microseconds>(os::now().time_since_epoch());
  notify(fmt::format("RELOADING=1\nMONOTONIC_USEC={}", now.count()));
}

void ServiceManager::stopping() { notify("STOPPING=1"); }

void ServiceManager::feed() {
  notify("WATCHDOG=1");
  timer_.set(os::now() + interval_);
}

void ServiceManager::notify(std::string_view text) const {
  sockaddr_un address{};
  if (path_.empty() || path_.size() >= sizeof address.sun_path) return;
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path_.data(), path_.size());
  if (path_[0] == '@') address.sun_path[0] = '\0';  // an abstract name
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path_.size());
  const os::File socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  // A manager that does not listen is no reason to stop.
  ::sendto(socket.get(), text.data(), text.size(), MSG_NOSIGNAL,
           reinterpret_cast<const sockaddr*>(&address), size);
}

void raise_descriptor_limit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace tims::io
