#include "tools/timsctl/process.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <filesystem>

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "os/file.h"
#include "tools/timsctl/failure.h"

namespace timsctl {

namespace {

namespace fs = std::filesystem;
using tims::os::File;

std::string words_of(int error) { return std::generic_category().message(error); }

Failure system_failure(const std::string& what) {
  return {Exit::kNo, "system", fmt::format("{}: {}", what, words_of(errno))};
}

// Beside timsctl, so that a build's tools start the build's router.
std::string found_program(const std::string& name) {
  if (name.find('/') != std::string::npos) return name;
  std::error_code ignored;
  const fs::path beside = fs::read_symlink("/proc/self/exe", ignored).parent_path() / name;
  return ::access(beside.c_str(), X_OK) == 0 ? beside.string() : name;
}

std::vector<std::string> environment_with(const std::vector<std::string>& added) {
  std::vector<std::string> all = added;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view line = *entry;
    const std::string_view name = line.substr(0, line.find('=') + 1);
    const auto is_said = [&](const std::string& other) { return other.starts_with(name); };
    if (std::ranges::none_of(added, is_said)) all.emplace_back(line);
  }
  return all;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  result.reserve(texts.size() + 1);
  for (std::string& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

// Everything that needs memory, made before the fork.
struct Prepared {
  explicit Prepared(const Launch& launch)
      : words(launch.command),
        environment(environment_with(launch.environment)),
        folder(launch.folder) {
    words.front() = found_program(words.front());
    argv = pointers(words);
    env = pointers(environment);
    if (launch.network.empty()) return;
    network = File(::open(namespace_path(launch.network).c_str(), O_RDONLY | O_CLOEXEC));
    if (!network) throw system_failure("namespace " + launch.network);
  }

  std::vector<std::string> words;
  std::vector<std::string> environment;
  std::string folder;
  std::vector<char*> argv;
  std::vector<char*> env;
  File network;
};

// What stdin, stdout and stderr become; -1: they stay.
struct Streams {
  int in = -1;
  int out = -1;
};

// From here on only what is safe in the copy of a program that may have had several threads.
void execute(const Prepared& program, Streams streams) {
  sigset_t none;
  sigemptyset(&none);
  ::pthread_sigmask(SIG_SETMASK, &none, nullptr);
  ::signal(SIGPIPE, SIG_DFL);
  if (program.network && ::setns(program.network.get(), CLONE_NEWNET) != 0) return;
  if (!program.folder.empty() && ::chdir(program.folder.c_str()) != 0) return;
  if (streams.in >= 0) ::dup2(streams.in, STDIN_FILENO);
  if (streams.out >= 0) {
    ::dup2(streams.out, STDOUT_FILENO);
    ::dup2(streams.out, STDERR_FILENO);
  }
  ::execvpe(program.argv[0], program.argv.data(), program.env.data());
}

std::string_view package_of(std::string_view program) {
  if (program == "ip" || program == "tc") return "iproute2";
  if (program == "nft") return "nftables";
  if (program == "fast-discovery-server") return "fastdds-tools";
  return {};
}

Failure cannot_execute(const Prepared& program, int error) {
  const std::string& name = program.words.front();
  const std::string_view package = package_of(name);
  return {error == ENOENT ? Exit::kNoSuch : Exit::kDenied, "cannot_execute",
          fmt::format("cannot run {}: {}", name, words_of(error)),
          package.empty() ? "it is looked for beside timsctl and in $PATH"
                          : fmt::format("apt-get install {}", package)};
}

// `own_group`: not of our terminal's Ctrl-C; ended when we end.
pid_t fork_and_execute(const Prepared& program, Streams streams, bool own_group) {
  tims::os::Pipe problem =
      value_or_fail(tims::os::make_pipe(), "pipe");  // closed by a successful exec
  const pid_t parent = ::getpid();
  const pid_t pid = ::fork();
  if (pid < 0) throw system_failure("fork");
  if (pid == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (own_group) ::setpgid(0, 0);
    if (::getppid() == parent) execute(program, streams);
    const int error = errno;
    [[maybe_unused]] const ssize_t n = ::write(problem.write.get(), &error, sizeof error);
    ::_exit(127);
  }
  problem.write.reset();
  int error = 0;
  if (::read(problem.read.get(), &error, sizeof error) <= 0) return pid;
  ::waitpid(pid, nullptr, 0);
  throw cannot_execute(program, error);
}

int exit_status(pid_t pid) {
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

File memory_file(std::string_view content) {
  File file(::memfd_create("timsctl", MFD_CLOEXEC));
  if (!file) throw system_failure("memfd_create");
  const ssize_t n = ::write(file.get(), content.data(), content.size());
  if (n != static_cast<ssize_t>(content.size())) throw system_failure("memfd_create");
  ::lseek(file.get(), 0, SEEK_SET);
  return file;
}

std::string content_of(const File& file) {
  std::string text;
  std::array<char, 4096> buffer{};
  ::lseek(file.get(), 0, SEEK_SET);
  for (ssize_t n = 0; (n = ::read(file.get(), buffer.data(), buffer.size())) > 0;)
    text.append(buffer.data(), static_cast<std::size_t>(n));
  return text;
}

}  // namespace

Ran run(const Launch& launch, std::string_view input) {
  const Prepared program(launch);
  const File in = memory_file(input);
  const File out = memory_file({});
  const pid_t pid = fork_and_execute(program, {in.get(), out.get()}, false);
  const int code = exit_status(pid);
  return {code, content_of(out)};
}

void run_or_fail(const Launch& launch, std::string_view input) {
  const Ran ran = run(launch, input);
  if (ran.code == 0) return;
  std::string text = ran.output;
  while (text.ends_with('\n')) text.pop_back();
  throw Failure(Exit::kDenied, "system",
                fmt::format("{} (in {}): {}", fmt::join(launch.command, " "),
                            launch.network.empty() ? "this host" : launch.network, text),
                "network namespaces need the rights of root and of CAP_NET_ADMIN");
}

Child Child::start(const Launch& launch) {
  const Prepared program(launch);
  const File null(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  File log;
  if (!launch.log.empty()) {
    log = File(::open(launch.log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
    if (!log) throw system_failure(launch.log);
  }
  const Streams streams{.in = launch.in >= 0 ? launch.in : null.get(),
                        .out = launch.out >= 0 ? launch.out : log.get()};
  const pid_t pid = fork_and_execute(program, streams, true);
  File pidfd(static_cast<int>(::syscall(SYS_pidfd_open, pid, 0)));
  if (!pidfd) throw system_failure("pidfd_open");
  return {pid, std::move(pidfd)};
}

void Child::signal(int number) const {
  if (::kill(-pid_, number) != 0) ::kill(pid_, number);
}

int Child::reap() const { return exit_status(pid_); }

std::string end_text(int status) {
  return status > 128 ? fmt::format("killed by signal {}", status - 128)
                      : fmt::format("exit status {}", status);
}

void become(const Launch& launch) {
  const Prepared program(launch);
  execute(program, {});
  throw cannot_execute(program, errno);
}

std::string namespace_path(std::string_view network) {
  return fmt::format("/run/netns/{}", network);
}

std::vector<pid_t> processes_in(std::string_view network) {
  std::vector<pid_t> found;
  struct stat wanted {};
  if (::stat(namespace_path(network).c_str(), &wanted) != 0) return found;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator("/proc", ignored)) {
    const std::string name = entry.path().filename();
    pid_t pid = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), pid);
    if (error != std::errc{} || end != name.data() + name.size() || pid == ::getpid()) continue;
    struct stat its {};
    if (::stat((entry.path() / "ns/net").c_str(), &its) == 0 && its.st_ino == wanted.st_ino &&
        its.st_dev == wanted.st_dev)
      found.push_back(pid);
  }
  return found;
}

}  // namespace timsctl
