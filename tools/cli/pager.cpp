#include "tools/cli/pager.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>

#include <spawn.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/text.h"
#include "os/environment.h"
#include "os/file.h"

namespace timsctl {
namespace {

// Empty: none. A pager is a command of a shell, such as "less -S".
std::string pager() {
  for (const char* name : {"TIMS_PAGER", "PAGER"}) {
    // NOLINTNEXTLINE(concurrency-mt-unsafe): the environment is never changed
    if (std::getenv(name) == nullptr) continue;
    std::string command = tims::os::environment(name);
    return command == "cat" ? "" : command;
  }
  return "command -v less >/dev/null 2>&1 || exit 127; exec less";
}

// The attributes of the pager's process: this program blocks and ignores signals.
class PagerAttributes {
 public:
  PagerAttributes() {
    ::posix_spawnattr_init(&attributes_);
    sigset_t none;
    sigset_t usual;
    sigemptyset(&none);
    sigemptyset(&usual);
    sigaddset(&usual, SIGPIPE);
    ::posix_spawnattr_setsigmask(&attributes_, &none);
    ::posix_spawnattr_setsigdefault(&attributes_, &usual);
    ::posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  ~PagerAttributes() { ::posix_spawnattr_destroy(&attributes_); }
  PagerAttributes(const PagerAttributes&) = delete;
  PagerAttributes& operator=(const PagerAttributes&) = delete;
  [[nodiscard]] const posix_spawnattr_t* get() const { return &attributes_; }

 private:
  posix_spawnattr_t attributes_{};
};

// The process that reads its stdin from this file; 0: it could not be started.
pid_t start_pager(const std::string& command, int input) {
  std::array<std::string, 3> words{"sh", "-c", command};
  std::array<char*, 4> arguments{words[0].data(), words[1].data(), words[2].data(), nullptr};
  // less ends at once if the text fits, shows colours, and leaves the text on the terminal.
  ::setenv("LESS", "FRX", 0);  // NOLINT(concurrency-mt-unsafe): there are no threads that read it
  posix_spawn_file_actions_t files;
  ::posix_spawn_file_actions_init(&files);
  ::posix_spawn_file_actions_adddup2(&files, input, STDIN_FILENO);
  pid_t pid = 0;
  const PagerAttributes attributes;
  if (::posix_spawn(&pid, "/bin/sh", &files, attributes.get(), arguments.data(), environ) != 0)
    pid = 0;
  ::posix_spawn_file_actions_destroy(&files);
  return pid;
}

}  // namespace

std::size_t rows_of(std::string_view text, std::size_t columns) {
  std::size_t rows = 0;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    std::string plain;
    bool escaped = false;
    for (const char c : line) {
      if (c == '\033') escaped = true;
      if (!escaped) plain += c;
      if (c == 'm') escaped = false;
    }
    const std::size_t width = base::display_width(plain);
    rows += columns == 0 ? 1 : std::max<std::size_t>(1, (width + columns - 1) / columns);
  }
  return rows;
}

bool show_in_pager(std::string_view text) {
  winsize size{};
  if (::isatty(STDIN_FILENO) == 0 || ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0) return false;
  if (size.ws_row == 0 || rows_of(text, size.ws_col) < size.ws_row) return false;
  const std::string command = pager();
  if (command.empty()) return false;
  auto pipe = tims::os::make_pipe();
  if (!pipe) return false;
  const pid_t pid = start_pager(command, pipe->read.get());
  pipe->read.reset();
  if (pid == 0) return false;
  // The user may leave the pager before it has read everything.
  while (!text.empty()) {
    const ssize_t n = ::write(pipe->write.get(), text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    text.remove_prefix(static_cast<std::size_t>(n));
  }
  pipe->write.reset();
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  constexpr int kNotFound = 127;  // of the shell
  return !(WIFEXITED(status) && WEXITSTATUS(status) == kNotFound);
}

}  // namespace timsctl
