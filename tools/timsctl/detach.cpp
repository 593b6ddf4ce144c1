#include "tools/timsctl/detach.h"

#include <array>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "os/file.h"
#include "tools/timsctl/failure.h"

namespace timsctl {

namespace {

void speak_to(const std::string& log) {
  const tims::os::File file(::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
  const tims::os::File null(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  ::dup2(null.get(), STDIN_FILENO);
  ::dup2(file.get(), STDOUT_FILENO);
  ::dup2(file.get(), STDERR_FILENO);
}

}  // namespace

Exit run_detached(const std::string& log,
                  const std::function<Exit(const std::function<void()>& ready)>& work) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0)
    throw Failure(Exit::kNo, "system", "pipe: no free file descriptor");
  const tims::os::File read_end(ends[0]);
  tims::os::File write_end(ends[1]);
  const pid_t pid = ::fork();
  if (pid < 0) throw Failure(Exit::kNo, "system", "fork: the system has no room for a process");
  if (pid == 0) {
    ::setsid();
    return work([&] {
      speak_to(log);
      [[maybe_unused]] const ssize_t n = ::write(write_end.get(), "1", 1);
      write_end.reset();
    });
  }
  write_end.reset();
  char ready = 0;
  if (::read(read_end.get(), &ready, 1) == 1) return Exit::kDone;
  int status = 0;
  ::waitpid(pid, &status, 0);
  return WIFEXITED(status) ? static_cast<Exit>(WEXITSTATUS(status)) : Exit::kNo;
}

}  // namespace timsctl
