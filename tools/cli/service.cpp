#include "tools/cli/service.h"

#include <algorithm>
#include <climits>
#include <csignal>
#include <filesystem>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/measure.h"
#include "base/text.h"
#include "os/clock.h"
#include "os/wakeup.h"

namespace timsctl {

namespace {

constexpr std::size_t kWaitingMax = 1 << 20;  // bytes of lines that nobody reads

void speak_to(const std::string& log) {
  const tims::os::File file(::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
  const tims::os::File null(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  ::dup2(null.get(), STDIN_FILENO);
  ::dup2(file.get(), STDOUT_FILENO);
  ::dup2(file.get(), STDERR_FILENO);
}

std::string_view package_of(std::string_view program) {
  if (program == "ip" || program == "tc") return "iproute2";
  if (program == "nft") return "nftables";
  if (program == "fast-discovery-server") return "fastdds-tools";
  return {};
}

// The reason why a program was not started; errno is set by os/process.h.
Failure not_started(const Launch& launch, const tims::Error& error) {
  const bool is_missing = errno == ENOENT;
  if (error.code() != tims::Errc::kInvalidArgument) return {Exit::kNo, "system", error.detail()};
  const std::string_view package = package_of(launch.command.front());
  return {is_missing ? Exit::kNoSuch : Exit::kDenied, "cannot_execute", error.detail(),
          package.empty() ? "it is searched in the folder of timsctl and in $PATH"
                          : fmt::format("apt-get install {}", package)};
}

Exit run_detached(const std::string& log, const Work& work) {
  tims::os::Pipe pipe = value_or_fail(tims::os::make_pipe(), "pipe");
  const pid_t pid = ::fork();
  if (pid < 0) throw Failure(Exit::kNo, "system", "fork: the system cannot create another process");
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

}  // namespace

Ran run(const Launch& launch, std::string_view input) {
  auto ran = tims::os::run_to_end(launch, input);
  if (!ran) throw not_started(launch, ran.error());
  return std::move(*ran);
}

void run_or_fail(const Launch& launch, std::string_view input) {
  const Ran ran = run(launch, input);
  if (ran.status.success()) return;
  std::string text = ran.output;
  while (text.ends_with('\n')) text.pop_back();
  throw Failure(Exit::kDenied, "system",
                fmt::format("{} (in {}): {}", fmt::join(launch.command, " "),
                            launch.network.empty() ? "this host" : launch.network, text),
                "network namespaces require root and CAP_NET_ADMIN");
}

Process start(Launch launch) {
  launch.own_group = true;
  auto process = Process::start(launch);
  if (!process) throw not_started(launch, process.error());
  return std::move(*process);
}

void become(const Launch& launch) { throw not_started(launch, tims::os::become(launch)); }

std::optional<pid_t> Child::pid() const {
  return process_ ? std::optional(process_->pid()) : std::nullopt;
}

int Child::descriptor() const { return process_ ? process_->descriptor() : -1; }

void Child::signal(int number) const {
  if (process_) process_->signal_group(number);
}

std::optional<tims::os::ExitStatus> Child::take_end(tims::Duration within) {
  if (!process_ || !process_->has_ended(within)) return std::nullopt;
  const tims::os::ExitStatus status = process_->reap();
  process_.reset();
  return status;
}

void end_all(std::span<const Child* const> children, int signal, tims::Duration patience,
             const std::function<void(tims::Time deadline)>& look_after) {
  for (const Child* child : children) child->signal(signal);
  tims::Time deadline = tims::os::deadline_after(patience);
  while (std::ranges::any_of(children, &Child::runs)) {
    if (tims::os::now() >= deadline) {
      for (const Child* child : children) child->signal(SIGKILL);
      deadline = tims::os::deadline_after(patience);
    }
    look_after(deadline);
  }
}

Exit run_service(const Context& context, const std::string& log, std::string_view is_up,
                 const Work& work) {
  if (context.options.detach) return run_detached(log, work);
  return work([&] {
    context.out.note(fmt::format(
        "{}; {}", is_up,
        context.options.run_for ? "it stops at the end of --for" : "stop it with Ctrl-C"));
  });
}

EventLines::EventLines(Context& context, std::string_view schema, int subject_width)
    : context_(context), schema_(schema), subject_width_(subject_width), began_(tims::os::now()) {}

EventLines::~EventLines() {
  constexpr tims::Duration kPatience = std::chrono::milliseconds(500);
  const tims::Time end = tims::os::deadline_after(kPatience);
  try {
    for (; !waiting_.empty() && tims::os::now() < end; flush())
      (void)tims::os::is_ready(STDOUT_FILENO, POLLOUT, end);
  } catch (const Interrupted&) {
    waiting_.clear();  // the reader has closed it
  }
}

void EventLines::begin() { began_ = tims::os::now(); }

void EventLines::write_line(std::string_view event, std::string_view subject,
                            std::string_view text) {
  if (context_.options.quiet && !context_.out.json()) return;
  const std::string line = line_of(event, subject, text);
  if (waiting_.size() + line.size() > kWaitingMax) {
    ++dropped_;
  } else {
    waiting_ += line;
  }
  flush();
}

std::string EventLines::line_of(std::string_view event, std::string_view subject,
                                std::string_view text) const {
  const double t = base::seconds(tims::os::now() - began_);
  if (context_.out.json())
    return to_text(json::object{{"schema", schema_},
                                {"time", base::rfc3339(tims::os::wall_now())},
                                {"t_s", t},
                                {"event", event},
                                {"subject", subject},
                                {"text", text}}) +
           "\n";
  return fmt::format("{:8.2f} s  {:<{}} {}\n", t, subject, subject_width_,
                     base::printable_lines(text));
}

// A pipe or terminal that is ready takes so much without waiting.
void EventLines::flush() {
  std::size_t written = 0;
  while (written < waiting_.size() && tims::os::is_ready(STDOUT_FILENO, POLLOUT, {})) {
    const auto part = std::string_view(waiting_).substr(written, PIPE_BUF);
    context_.out.write(part);
    written += part.size();
  }
  waiting_.erase(0, written);
  if (!waiting_.empty() || dropped_ == 0) return;
  waiting_ = line_of("said", "timsctl",
                     fmt::format("{} lines are lost: nobody has read the output", dropped_));
  dropped_ = 0;
}

tims::Time EventLines::flush_at() const {
  constexpr tims::Duration kPause = std::chrono::milliseconds(50);
  return waiting_.empty() ? tims::kNever : tims::os::deadline_after(kPause);
}

void keep_log_short(const std::string& log, std::size_t bytes_max) {
  struct stat here {};
  struct stat there {};
  if (::fstat(STDOUT_FILENO, &here) != 0 || ::stat(log.c_str(), &there) != 0) return;
  if (here.st_ino != there.st_ino || here.st_dev != there.st_dev || !S_ISREG(here.st_mode)) return;
  if (static_cast<std::size_t>(here.st_size) <= bytes_max) return;
  std::error_code ignored;
  std::filesystem::rename(log, log + ".1", ignored);
  speak_to(log);
}

}  // namespace timsctl
