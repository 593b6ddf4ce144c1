#include "tools/timsctl/detach.h"

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
  tims::os::Pipe pipe = value_or_fail(tims::os::make_pipe(), "pipe");
  const pid_t pid = ::fork();
  if (pid < 0) throw Failure(Exit::kNo, "system", "fork: the system has no room for a process");
  if (pid == 0) {
    ::setsid();
    return work([&] {
      speak_to(log);
      [[maybe_unused]] const ssize_t n = ::write(pipe.write.get(), "1", 1);
      pipe.write.reset();
    });
  }
  pipe.write.reset();
  char ready = 0;
  if (::read(pipe.read.get(), &ready, 1) == 1) return Exit::kDone;
  int status = 0;
  ::waitpid(pid, &status, 0);
  return WIFEXITED(status) ? static_cast<Exit>(WEXITSTATUS(status)) : Exit::kNo;
}

}  // namespace timsctl
