#include "tests/support/child_process.h"

#include <array>
#include <cerrno>
#include <condition_variable>
#include <csignal>
#include <mutex>
#include <optional>
#include <thread>

#include <poll.h>
#include <unistd.h>

#include "os/clock.h"
#include "os/file.h"

namespace tims::test {
namespace {

struct OutputLine {
  bool is_error = false;
  std::string text;
};

}  // namespace

struct ChildProcess::State {
  State(os::Process started, os::Pipe& out, os::Pipe& err)
      : process(std::move(started)),
        streams{Stream{std::move(out.read), false, {}}, Stream{std::move(err.read), true, {}}},
        reader([this] { read_to_the_end(); }) {}
  ~State();

  struct Stream {
    os::File file;
    bool is_error = false;
    std::string rest;  // an incomplete line
  };

  void read_to_the_end();
  bool read_some(Stream& stream);  // false at its end
  std::optional<std::string> find(std::string_view part);
  [[nodiscard]] std::string joined() const;

  os::Process process;
  std::optional<ExitStatus> exit_status;

  mutable std::mutex mutex;
  std::condition_variable changed;
  std::vector<OutputLine> lines;
  std::size_t searched = 0;  // lines before this index were returned already
  bool ended = false;

  std::array<Stream, 2> streams;  // used by the reader only
  std::thread reader;             // last member: it uses all others
};

Result<ChildProcess> ChildProcess::start(std::vector<std::string> command,
                                         const ChildOptions& options) {
  auto out = os::make_pipe();
  if (!out) return out.error();
  auto err = os::make_pipe();
  if (!err) return err.error();
  auto process = os::Process::start({.command = std::move(command),
                                     .environment = options.environment,
                                     .folder = options.folder,
                                     .out = out->write.get(),
                                     .err = err->write.get()});
  out->write.reset();
  err->write.reset();
  if (!process) return process.error();
  return ChildProcess(std::make_unique<State>(std::move(*process), *out, *err));
}

ChildProcess::ChildProcess(std::unique_ptr<State> state) : state_(std::move(state)) {}
ChildProcess::ChildProcess(ChildProcess&&) noexcept = default;
ChildProcess& ChildProcess::operator=(ChildProcess&&) noexcept = default;
ChildProcess::~ChildProcess() = default;

ChildProcess::State::~State() {
  if (!exit_status) {
    process.signal(SIGKILL);
    (void)process.reap();
  }
  // A grandchild may keep the pipes open for ever, so reading stops here.
  {
    const std::lock_guard lock(mutex);
    ended = true;
  }
  reader.join();
}

pid_t ChildProcess::pid() const { return state_->process.pid(); }

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
  if (!state_->exit_status) state_->process.signal(number);
}

Result<ExitStatus> ChildProcess::wait(Duration limit) {
  if (state_->exit_status) return *state_->exit_status;
  const Time deadline = os::deadline_after(limit);
  if (!state_->process.has_ended(limit))
    return Error(Errc::kTimeout, "process " + std::to_string(pid()) + " still runs");
  state_->exit_status = state_->process.reap();
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

std::string only(const std::vector<OutputLine>& lines, bool is_error) {
  std::string text;
  for (const OutputLine& line : lines) {
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

// Runs in a separate thread, so that the test never blocks a child with much output.
void ChildProcess::State::read_to_the_end() {
  constexpr int kLookAgainMs = 100;  // to check whether the destructor requests the end
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
  for (const OutputLine& line : lines) text.append(line.text).append("\n");
  return text;
}

}  // namespace tims::test
