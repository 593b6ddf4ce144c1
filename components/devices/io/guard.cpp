#include "components/devices/io/guard.h"

#include <cerrno>
#include <csignal>
#include <span>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

namespace rack::device {
namespace {

using tims::Result;
using tims::os::File;
using tims::os::system_error;

constexpr char kReleased = 'r';

// From here to _exit(), only functions that are async-signal-safe may be called: this code runs
// after fork() of a program with threads.

// Returns false if the line has not accepted the bytes for 1 s.
bool write_whole(int line, std::span<const std::byte> piece) {
  constexpr int kPause = 1;  // ms
  constexpr int kAttempts = 1000;
  for (int attempt = 0; attempt < kAttempts && !piece.empty(); ++attempt) {
    const ssize_t written = ::write(line, piece.data(), piece.size());
    if (written > 0) piece = piece.subspan(static_cast<std::size_t>(written));
    // When the queue of a CAN interface is full (ENOBUFS), poll() still reports it as writable.
    const bool is_full = written < 0 && (errno == EAGAIN || errno == ENOBUFS);
    if (written < 0 && !is_full && errno != EINTR) return false;
    if (is_full) ::poll(nullptr, 0, kPause);
  }
  return piece.empty();
}

[[noreturn]] void stand_guard(int line, int alive,
                              const std::vector<std::vector<std::byte>>& stop_commands) {
  ::prctl(PR_SET_NAME, "device-guard");
  // Blocks all signals: signals to the driver's process group must not end the guard.
  sigset_t all;
  ::sigfillset(&all);
  ::sigprocmask(SIG_SETMASK, &all, nullptr);
  // Closes all other descriptors: inherited sockets would make peers believe that the driver is
  // still running.
  if (::dup2(line, 0) < 0 || ::dup2(alive, 1) < 0) ::_exit(1);
  ::close_range(2, ~0U, 0);
  char release = 0;
  ssize_t got = 0;
  do {
    got = ::read(1, &release, 1);
  } while (got < 0 && errno == EINTR);
  if (got == 1) ::_exit(0);
  for (const auto& piece : stop_commands)
    if (!write_whole(0, piece)) break;
  ::_exit(0);
}

}  // namespace

Result<std::unique_ptr<Guard>> Guard::start(
    int line, const std::vector<std::vector<std::byte>>& stop_commands) {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    return system_error("cannot create the socket of the device guard");
  // The duplicates must be above the descriptors that the guard uses itself.
  constexpr int kAbove = 3;
  File reads(ends[0]);
  File writes(ends[1]);
  File own_line(::fcntl(line, F_DUPFD_CLOEXEC, kAbove));
  File own_read(::fcntl(reads.get(), F_DUPFD_CLOEXEC, kAbove));
  if (!own_line || !own_read) return system_error("cannot duplicate the line for the device guard");
  const pid_t process = ::fork();
  if (process < 0) return system_error("cannot start the device guard");
  if (process == 0) stand_guard(own_line.get(), own_read.get(), stop_commands);
  return std::unique_ptr<Guard>(new Guard(std::move(writes), process));
}

Guard::~Guard() {
  while (::send(alive_.get(), &kReleased, 1, MSG_NOSIGNAL) < 0 && errno == EINTR) {
  }
  alive_.reset();
  while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

}  // namespace rack::device
