#include "tools/cli/signals.h"

#include <array>
#include <csignal>

#include <poll.h>
#include <sys/signalfd.h>

#include "os/clock.h"
#include "tools/cli/failure.h"

namespace timsctl {

Signals::Signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&set, number);
  ::pthread_sigmask(SIG_BLOCK, &set, nullptr);
  // A reader that goes away is an error of write(), not a sudden end without cleaning up.
  std::signal(SIGPIPE, SIG_IGN);
  file_ = tims::os::File(::signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK));
}

Signals::Woken Signals::wait(int fd, tims::Time deadline) const {
  std::array<pollfd, 2> waits{{{file_.get(), POLLIN, 0}, {fd, POLLIN, 0}}};
  const auto rest = std::max(deadline - tims::os::now(), tims::Duration::zero());
  const timespec limit = tims::os::to_timespec(tims::Time(rest));
  const int ready =
      ::ppoll(waits.data(), waits.size(), deadline == tims::kNever ? nullptr : &limit, nullptr);
  if (waits[0].revents != 0) throw Interrupted();
  return ready > 0 ? Woken::kReadable : Woken::kTimeout;
}

}  // namespace timsctl
