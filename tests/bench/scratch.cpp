#include "tests/bench/scratch.h"

#include <csignal>
#include <cstdlib>
#include <filesystem>

#include <unistd.h>

#include "tests/bench/two_hosts.h"

namespace tims::bench {
namespace {

void remove(const std::string& path) {
  std::error_code ignored;
  std::filesystem::remove_all(path, ignored);
}

sigset_t ending_signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGUSR1}) sigaddset(&set, number);
  return set;
}

}  // namespace

Scratch::Scratch() {
  std::string name = "/dev/shm/tims-bench-XXXXXX";
  if (::mkdtemp(name.data()) == nullptr) {
    name = "/tmp/tims-bench-XXXXXX";
    if (::mkdtemp(name.data()) == nullptr) std::perror("mkdtemp");
  }
  path_ = name;
  const sigset_t signals = ending_signals();
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  watcher_ = std::thread([this] { wait_for_signal(); });
}

Scratch::~Scratch() {
  ::pthread_kill(watcher_.native_handle(), SIGUSR1);  // the run is over
  watcher_.join();
  remove(path_);
}

// The processes of the measurement exit with this one. A forked copy removes the rest, so that the
// run, which detects their exit, starts nothing new in the meantime.
void Scratch::wait_for_signal() const {
  const sigset_t signals = ending_signals();
  int number = 0;
  ::sigwait(&signals, &number);
  if (number == SIGUSR1) return;
  const pid_t run = ::getpid();
  if (::fork() != 0) ::_exit(128 + number);
  while (::getppid() == run) ::usleep(1000);
  remove(path_);
  remove_own_hosts();
  ::_exit(0);
}

}  // namespace tims::bench
