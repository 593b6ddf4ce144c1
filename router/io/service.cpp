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

using boost::system::error_code;

sigset_t handled_signals() {
  sigset_t set;
  ::sigemptyset(&set);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) ::sigaddset(&set, signal);
  return set;
}

long long number_in(const char* name) {
  const char* text = std::getenv(name);
  if (text == nullptr) return 0;
  long long value = 0;
  std::from_chars(text, text + std::strlen(text), value);
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

Signals::Signals(boost::asio::io_context& loop, Actions actions)
    : actions_(std::move(actions)), socket_(loop) {
  const sigset_t set = handled_signals();
  ::sigprocmask(SIG_BLOCK, &set, nullptr);
  file_ = os::File(::signalfd(-1, &set, SFD_NONBLOCK | SFD_CLOEXEC));
  socket_.assign(file_.get());
  wait();
}

Signals::~Signals() { socket_.release(); }

void Signals::wait() {
  socket_.async_wait(boost::asio::posix::stream_descriptor::wait_read,
                     [this](const error_code& error) {
                       if (error) return;
                       take();
                       wait();
                     });
}

void Signals::take() {
  signalfd_siginfo signal{};
  while (::read(file_.get(), &signal, sizeof signal) == sizeof signal) {
    (signal.ssi_signo == SIGHUP ? actions_.reload : actions_.stop)();
  }
}

// --- ServiceManager

ServiceManager::ServiceManager(boost::asio::io_context& loop) : timer_(loop) {
  if (const char* path = std::getenv("NOTIFY_SOCKET")) path_ = path;
  if (!path_.empty()) interval_ = watchdog_interval();
}

void ServiceManager::ready() {
  notify("READY=1");
  if (interval_.count() > 0) feed();
}

void ServiceManager::reloading() {
  const auto now =
      std::chrono::duration_cast<std::chrono::microseconds>(os::now().time_since_epoch());
  notify(fmt::format("RELOADING=1\nMONOTONIC_USEC={}", now.count()));
}

void ServiceManager::stopping() { notify("STOPPING=1"); }

void ServiceManager::feed() {
  timer_.expires_after(interval_);
  timer_.async_wait([this](const error_code& error) {
    if (error) return;
    notify("WATCHDOG=1");
    feed();
  });
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
