#include "os/tunnel.h"

#include <array>
#include <csignal>

#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include "os/environment.h"

namespace tims::os {
namespace {

constexpr const char* kProgram = "timsctl";

// A session of its own: Ctrl-C in a terminal ends this program first, and the tunnel with its
// connection. Signals that are blocked here are not blocked there.
struct Spawning {
  Spawning() {
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawnattr_init(&attributes);
    sigset_t none;
    sigemptyset(&none);
    ::posix_spawnattr_setsigmask(&attributes, &none);
    ::posix_spawnattr_setflags(&attributes,
                               static_cast<short>(POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSID));
  }
  Spawning(const Spawning&) = delete;
  Spawning& operator=(const Spawning&) = delete;
  ~Spawning() {
    ::posix_spawn_file_actions_destroy(&actions);
    ::posix_spawnattr_destroy(&attributes);
  }
  posix_spawn_file_actions_t actions{};
  posix_spawnattr_t attributes{};
};

}  // namespace

Result<File> connect_by_tunnel(const std::string& router) {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends.data()) != 0)
    return system_error("socketpair");
  File mine(ends[0]);
  const File its(ends[1]);
  Spawning spawning;
  ::posix_spawn_file_actions_adddup2(&spawning.actions, its.get(), STDIN_FILENO);
  std::array<std::string, 4> words{kProgram, "tunnel", "-", router};
  std::array<char*, 5> arguments{words[0].data(), words[1].data(), words[2].data(), words[3].data(),
                                 nullptr};
  pid_t pid = 0;
  const int error = ::posix_spawnp(&pid, find_program(kProgram).c_str(), &spawning.actions,
                                   &spawning.attributes, arguments.data(), environ);
  if (error != 0) {
    errno = error;
    return system_error("TLS needs timsctl, which cannot be started");
  }
  // It goes on in the background at once.
  while (::waitpid(pid, nullptr, 0) < 0 && errno == EINTR) {
  }
  return mine;
}

}  // namespace tims::os
