#include "tests/support/child_process.h"

#include <array>
#include <cerrno>
#include <condition_variable>
#include <csignal>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "os/clock.h"
#include "os/file.h"
#include "os/wakeup.h"

namespace tims::test {
namespace {

struct Line {
  bool is_error = false;
  std::string text;
};

Result<pid_t> fork_and_exec(std::vector<std::string> command, const ChildOptions& options, int out,
                            int err);

}  // namespace

struct ChildProcess::State {
  State(pid_t id, os::Pipe& out, os::Pipe& err)
      : pid(id),
        pidfd(static_cast<int>(::syscall(SYS_pidfd_open, id, 0))),
        streams{Stream{std::move(out.read), false, {}}, Stream{std::move(err.read), true, {}}},
        reader([this] { read_to_the_end(); }) {}
  ~State();

  struct Stream {
    os::File file;
    bool is_error = false;
    std::string rest;  // of a line that has not ended
  };

  void read_to_the_end();
  bool read_some(Stream& stream);  // false at its end
  std::optional<std::string> find(std::string_view part);
  [[nodiscard]] std::string joined() const;

  pid_t pid;
  os::File pidfd;
  std::optional<ExitStatus> exit_status;

  mutable std::mutex mutex;
  std::condition_variable changed;
  std::vector<Line> lines;
  std::size_t searched = 0;  // lines before this one were found already
  bool ended = false;

  std::array<Stream, 2> streams;  // the reader's
  std::thread reader;             // last: needs all the others
};

std::string ExitStatus::to_string() const {
  if (signal != 0) return "killed by signal " + std::to_string(signal);
  return "exit status " + std::to_string(code);
}

Result<ChildProcess> ChildProcess::start(std::vector<std::string> command,
                                         const ChildOptions& options) {
  if (command.empty()) return Error(Errc::kInvalidArgument, "no command");
  auto out = os::make_pipe();
  if (!out) return out.error();
  auto err = os::make_pipe();
  if (!err) return err.error();
  const auto pid = fork_and_exec(std::move(command), options, out->write.get(), err->write.get());
  if (!pid) return pid.error();
  return ChildProcess(std::make_unique<State>(*pid, *out, *err));
}

ChildProcess::ChildProcess(std::unique_ptr<State> state) : state_(std::move(state)) {}
ChildProcess::ChildProcess(ChildProcess&&) noexcept = default;
ChildProcess& ChildProcess::operator=(ChildProcess&&) noexcept = default;
ChildProcess::~ChildProcess() = default;

ChildProcess::State::~State() {
  if (!exit_status) {
    ::kill(pid, SIGKILL);
    ::waitpid(pid, nullptr, 0);
  }
  // A grandchild may hold the pipes open for ever: nothing more is read.
  {
    const std::lock_guard lock(mutex);
    ended = true;
  }
  reader.join();
}

pid_t ChildProcess::pid() const { return state_->pid; }

Result<std::string> ChildProcess::wait_for_line(std::string_view part, Duration limit) {
  std::unique_lock lock(state_->mutex);
  std::optional<std::string> line;
  state_->changed.wait_for(lock, limit, [&] {
    line = state_->find(part);
    return line || state_->ended;
  });
  if (line) return *line;
  const std::string what = "no line with \"" + std::string(part) + "\" in this output:\n";
  return Error(state_->ended ? Errc::kClosed : Errc::kTimeout, what + state_->joined());
}

void ChildProcess::signal(int number) {
  if (!state_->exit_status) ::kill(state_->pid, number);
}

Result<ExitStatus> ChildProcess::wait(Duration limit) {
  if (state_->exit_status) return *state_->exit_status;
  const Time deadline = os::deadline_after(limit);
  if (!os::is_readable(state_->pidfd.get(), limit)) {
    return Error(Errc::kTimeout, "process " + std::to_string(state_->pid) + " still runs");
  }
  int status = 0;
  ::waitpid(state_->pid, &status, 0);
  state_->exit_status = WIFSIGNALED(status) ? ExitStatus{.signal = WTERMSIG(status)}
                                            : ExitStatus{.code = WEXITSTATUS(status)};
  std::unique_lock lock(state_->mutex);
  state_->changed.wait_for(lock, deadline - os::now(), [&] { return state_->ended; });
  return *state_->exit_status;
}

Result<ExitStatus> ChildProcess::stop(int number, Duration limit) {
  signal(number);
  return wait(limit);
}

std::string ChildProcess::output() const {
  const std::lock_guard lock(state_->mutex);
  return state_->joined();
}

namespace {

std::string only(const std::vector<Line>& lines, bool is_error) {
  std::string text;
  for (const Line& line : lines) {
    if (line.is_error == is_error) text.append(line.text).append("\n");
  }
  return text;
}

}  // namespace

std::string ChildProcess::standard_output() const {
  const std::lock_guard lock(state_->mutex);
  return only(state_->lines, false);
}

std::string ChildProcess::standard_error() const {
  const std::lock_guard lock(state_->mutex);
  return only(state_->lines, true);
}

// Runs in a thread of its own, so that a child that writes much is never held up by the test.
void ChildProcess::State::read_to_the_end() {
  constexpr int kLookAgainMs = 100;  // whether the destructor wants an end
  bool open[2] = {true, true};
  while (open[0] || open[1]) {
    std::array<pollfd, 2> ready{};
    for (std::size_t i = 0; i < 2; ++i)
      ready[i] = {open[i] ? streams[i].file.get() : -1, POLLIN, 0};
    ::poll(ready.data(), ready.size(), kLookAgainMs);
    for (std::size_t i = 0; i < 2; ++i) {
      if (ready[i].revents != 0) open[i] = read_some(streams[i]);
    }
    const std::lock_guard lock(mutex);
    if (ended) return;
  }
  const std::lock_guard lock(mutex);
  ended = true;
  changed.notify_all();
}

bool ChildProcess::State::read_some(Stream& stream) {
  std::array<char, 4096> buffer{};
  const ssize_t n = ::read(stream.file.get(), buffer.data(), buffer.size());
  if (n > 0) stream.rest.append(buffer.data(), static_cast<std::size_t>(n));
  const bool at_end = n == 0 || (n < 0 && errno != EINTR);
  if (at_end && !stream.rest.empty()) stream.rest += '\n';
  const std::lock_guard lock(mutex);
  for (std::size_t end = 0; (end = stream.rest.find('\n')) != std::string::npos;) {
    lines.push_back({stream.is_error, stream.rest.substr(0, end)});
    stream.rest.erase(0, end + 1);
  }
  changed.notify_all();
  return !at_end;
}

std::optional<std::string> ChildProcess::State::find(std::string_view part) {
  for (std::size_t i = searched; i < lines.size(); ++i) {
    if (lines[i].text.find(part) == std::string::npos) continue;
    searched = i + 1;
    return lines[i].text;
  }
  return std::nullopt;
}

std::string ChildProcess::State::joined() const {
  std::string text;
  for (const Line& line : lines) text.append(line.text).append("\n");
  return text;
}

namespace {

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  result.reserve(texts.size() + 1);
  for (std::string& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

std::vector<std::string> joined_environment(const std::vector<std::string>& added) {
  std::vector<std::string> all = added;  // the first of two equal names counts
  for (char** entry = environ; *entry != nullptr; ++entry) all.emplace_back(*entry);
  return all;
}

// Between fork and exec only what is safe in the copy of a program with several threads: all
// memory was prepared before. Writes errno to `problem` when it comes back at all.
void become(char** argv, char** env, const char* folder, int out, int err, pid_t parent,
            int problem) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(127);  // it died before the line above
  sigset_t none;
  sigemptyset(&none);
  ::pthread_sigmask(SIG_SETMASK, &none, nullptr);
  const int null = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  ::dup2(null, STDIN_FILENO);
  ::dup2(out, STDOUT_FILENO);
  ::dup2(err, STDERR_FILENO);
  if (*folder == '\0' || ::chdir(folder) == 0) ::execvpe(argv[0], argv, env);
  const int error = errno;
  [[maybe_unused]] const ssize_t n = ::write(problem, &error, sizeof error);
  ::_exit(127);
}

Result<pid_t> fork_and_exec(std::vector<std::string> command, const ChildOptions& options, int out,
                            int err) {
  std::vector<std::string> environment = joined_environment(options.environment);
  std::vector<char*> argv = pointers(command);
  std::vector<char*> env = pointers(environment);
  auto problem = os::make_pipe();  // closed by a successful exec
  if (!problem) return problem.error();
  const pid_t parent = ::getpid();
  const pid_t pid = ::fork();
  if (pid < 0) return os::system_error("fork");
  if (pid == 0) {
    become(argv.data(), env.data(), options.folder.c_str(), out, err, parent, problem->write.get());
  }
  problem->write.reset();
  int error = 0;
  if (::read(problem->read.get(), &error, sizeof error) <= 0) return pid;
  ::waitpid(pid, nullptr, 0);
  const std::string words = std::system_category().message(error);
  return Error(Errc::kSystem, "cannot start " + command[0] + ": " + words);
}

}  // namespace
}  // namespace tims::test
