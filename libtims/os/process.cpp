#include "os/process.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <filesystem>
#include <optional>

#include <fcntl.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "os/environment.h"
#include "os/file.h"

namespace tims::os {

namespace {

namespace fs = std::filesystem;

std::vector<std::string> environment_with(const std::vector<std::string>& added) {
  std::vector<std::string> all = added;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view line = *entry;
    const std::string_view name = line.substr(0, line.find('=') + 1);
    const auto is_overridden = [&](const std::string& other) { return other.starts_with(name); };
    if (std::ranges::none_of(added, is_overridden)) all.emplace_back(line);
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

// Everything that needs memory; it is allocated before the fork.
struct Prepared {
  std::vector<std::string> command;
  std::vector<std::string> environment;
  std::string folder;
  File network;
  std::vector<char*> argv{};
  std::vector<char*> env{};
};

Result<Prepared> prepare(const Launch& launch) {
  if (launch.command.empty()) return Error(Errc::kInvalidArgument, "no command");
  Prepared program{.command = launch.command,
                   .environment = environment_with(launch.environment),
                   .folder = launch.folder,
                   .network = {}};
  program.command.front() = find_program(program.command.front());
  program.argv = pointers(program.command);
  program.env = pointers(program.environment);
  if (launch.network.empty()) return program;
  program.network = File(::open(namespace_path(launch.network).c_str(), O_RDONLY | O_CLOEXEC));
  if (!program.network) return system_error("namespace " + launch.network);
  return program;
}

Error cannot_execute(const Prepared& program, int error) {
  errno = error;
  return {Errc::kInvalidArgument,
          "cannot run " + program.command.front() + ": " + std::generic_category().message(error)};
}

// Descriptors that become stdin, stdout and stderr, and one that stays open; -1: none.
struct Streams {
  int in = -1;
  int out = -1;
  int err = -1;
  int inherited = -1;
};

// From here on only async-signal-safe calls are allowed: the process is a copy of a program that
// may have had several threads.
void execute(const Prepared& program, Streams streams) {
  sigset_t none;
  sigemptyset(&none);
  ::pthread_sigmask(SIG_SETMASK, &none, nullptr);
  ::signal(SIGPIPE, SIG_DFL);
  if (program.network && ::setns(program.network.get(), CLONE_NEWNET) != 0) return;
  if (!program.folder.empty() && ::chdir(program.folder.c_str()) != 0) return;
  if (streams.in >= 0) ::dup2(streams.in, STDIN_FILENO);
  if (streams.out >= 0) ::dup2(streams.out, STDOUT_FILENO);
  if (streams.err >= 0) ::dup2(streams.err, STDERR_FILENO);
  if (streams.inherited >= 0) ::fcntl(streams.inherited, F_SETFD, 0);
  ::execvpe(program.argv[0], program.argv.data(), program.env.data());
}

Result<pid_t> fork_and_execute(const Prepared& program, Streams streams, bool own_group) {
  auto problem = make_pipe();  // closed by a successful exec
  if (!problem) return problem.error();
  const pid_t parent = ::getpid();
  const pid_t pid = ::fork();
  if (pid < 0) return system_error("fork");
  if (pid == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (own_group) ::setpgid(0, 0);
    if (::getppid() == parent) execute(program, streams);  // else the parent ended before the prctl
    const int error = errno;
    [[maybe_unused]] const ssize_t n = ::write(problem->write.get(), &error, sizeof error);
    ::_exit(127);
  }
  problem->write.reset();
  int error = 0;
  if (::read(problem->read.get(), &error, sizeof error) <= 0) return pid;
  ::waitpid(pid, nullptr, 0);
  return cannot_execute(program, error);
}

ExitStatus wait_for_exit(pid_t pid) {
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) return {.signal = WTERMSIG(status)};
  return {.code = WEXITSTATUS(status)};
}

// Input and output of a program that is run to completion. With a file, no thread has to read and
// write while the program runs.
Result<File> memory_file(std::string_view content) {
  File file(::memfd_create("stdio", MFD_CLOEXEC));
  if (!file ||
      ::write(file.get(), content.data(), content.size()) != static_cast<ssize_t>(content.size()))
    return system_error("memfd_create");
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

std::optional<pid_t> pid_of(const std::string& name) {
  pid_t pid = 0;
  const char* const end = name.data() + name.size();
  const auto [stop, error] = std::from_chars(name.data(), end, pid);
  return error == std::errc() && stop == end ? std::optional(pid) : std::nullopt;
}

}  // namespace

std::string ExitStatus::to_string() const {
  if (signal != 0) return "killed by signal " + std::to_string(signal);
  return "exit status " + std::to_string(code);
}

Result<Process> Process::start(const Launch& launch) {
  const auto program = prepare(launch);
  if (!program) return program.error();
  const File null(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  File log;
  if (!launch.log.empty()) {
    log = File(::open(launch.log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
    if (!log) return system_error(launch.log);
  }
  const int out = launch.out >= 0 ? launch.out : log.get();
  const auto pid = fork_and_execute(*program,
                                    {.in = launch.in >= 0 ? launch.in : null.get(),
                                     .out = out,
                                     .err = launch.err >= 0 ? launch.err : out,
                                     .inherited = launch.inherited},
                                    launch.own_group);
  if (!pid) return pid.error();
  File pidfd(static_cast<int>(::syscall(SYS_pidfd_open, *pid, 0)));
  if (!pidfd) return system_error("pidfd_open");
  return Process(*pid, std::move(pidfd));
}

void Process::signal(int number) const { ::kill(pid_, number); }

void Process::signal_group(int number) const {
  if (::kill(-pid_, number) != 0) ::kill(pid_, number);
}

ExitStatus Process::reap() const { return wait_for_exit(pid_); }

Result<Ran> run_to_end(const Launch& launch, std::string_view input) {
  const auto program = prepare(launch);
  if (!program) return program.error();
  const auto in = memory_file(input);
  if (!in) return in.error();
  const auto out = memory_file({});
  if (!out) return out.error();
  const auto pid = fork_and_execute(
      *program, {.in = in->get(), .out = out->get(), .err = out->get()}, launch.own_group);
  if (!pid) return pid.error();
  const ExitStatus status = wait_for_exit(*pid);
  return Ran{status, content_of(*out)};
}

Error become(const Launch& launch) {
  const auto program = prepare(launch);
  if (!program) return program.error();
  execute(*program, {});
  return cannot_execute(*program, errno);
}

std::string namespace_path(std::string_view network) {
  return "/run/netns/" + std::string(network);
}

std::vector<pid_t> processes_in(std::string_view network) {
  std::vector<pid_t> found;
  struct stat wanted {};
  if (::stat(namespace_path(network).c_str(), &wanted) != 0) return found;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator("/proc", ignored)) {
    const auto pid = pid_of(entry.path().filename());
    if (!pid || *pid == ::getpid()) continue;
    struct stat its {};
    if (::stat((entry.path() / "ns/net").c_str(), &its) == 0 && its.st_ino == wanted.st_ino &&
        its.st_dev == wanted.st_dev)
      found.push_back(*pid);
  }
  return found;
}

}  // namespace tims::os
