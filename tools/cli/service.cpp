#include "tools/cli/service.h"

#include <array>

#include <boost/json/parse.hpp>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/measure.h"
#include "base/text.h"
#include "os/clock.h"
#include "os/socket.h"
#include "os/wakeup.h"

namespace timsctl {

namespace {

constexpr std::size_t kQuestionMax = 4096;
constexpr std::size_t kServiceAnswerMax = 64 << 10;
constexpr tims::Duration kQuestionComes = std::chrono::seconds(1);

json::object as_json(const Failure& failure) {
  return {{"error", json::object{{"code", failure.code},
                                 {"message", failure.message},
                                 {"hint", failure.hint},
                                 {"exit", static_cast<int>(failure.exit)}}}};
}

void send_answer(const tims::os::File& socket, const json::object& answer) {
  const std::string text = to_text(answer);
  (void)tims::os::send_record(socket.get(), std::as_bytes(std::span(text)), {}, false);
}

void throw_error_of(const json::object& answer) {
  if (at_path(answer, "error") == nullptr) return;
  throw Failure(static_cast<Exit>(static_cast<int>(number_or_zero(answer, "error.exit"))),
                text_at(answer, "error.code"), text_at(answer, "error.message"),
                text_at(answer, "error.hint"));
}

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

bool somebody_listens(const std::string& path) { return tims::os::connect_unix(path).ok(); }

json::object ask_control(const std::string& path, const json::object& question,
                         const Signals& signals, tims::Duration timeout, const Failure& nobody) {
  const auto socket = tims::os::connect_unix(path);
  if (!socket) throw nobody;
  const std::string text = to_text(question);
  value_or_fail(tims::os::send_record(socket->get(), std::as_bytes(std::span(text))), path);
  std::vector<std::byte> answer(kServiceAnswerMax);
  if (signals.wait(socket->get(), tims::os::deadline_after(timeout)) ==
      Signals::WaitResult::kTimeout)
    throw Failure(Exit::kTimeout, "timeout", path + ": no answer", "use a longer --timeout");
  const auto received = value_or_fail(tims::os::receive_record(socket->get(), answer, false), path);
  json::object object = parse_object({reinterpret_cast<const char*>(answer.data()), received.size});
  throw_error_of(object);
  return object;
}

void ControlServer::wait(std::vector<int> others, const Signals& signals,
                         tims::Time deadline) const {
  others.push_back(listener_.get());
  const auto any = tims::os::any_of(others);
  (void)signals.wait(any ? any->get() : -1,
                     deadline);  // if accept fails, try again at the deadline
}

void ControlServer::take_question(
    const Signals& signals,
    const std::function<json::object(const json::object& question)>& answer) {
  auto socket = tims::os::accept_unix(listener_);
  if (!socket) return;
  if (signals.wait(socket->get(), tims::os::deadline_after(kQuestionComes)) ==
      Signals::WaitResult::kTimeout)
    return;
  std::array<std::byte, kQuestionMax> buffer{};
  const auto received = tims::os::receive_record(socket->get(), buffer, false);
  if (!received || received->size == 0) return;  // only a test whether this process listens
  try {
    const json::object question =
        parse_object({reinterpret_cast<const char*>(buffer.data()), received->size});
    if (text_at(question, "do") == "down")
      ending_ = std::move(*socket);
    else
      send_answer(*socket, answer(question));
  } catch (const Failure& failure) {
    send_answer(*socket, as_json(failure));
  }
}

void ControlServer::end(const json::object& answer) {
  listener_.reset();
  if (ending_) send_answer(ending_, answer);
}

json::object parse_object(std::string_view text) {
  boost::system::error_code error;
  json::value value = json::parse(text, error);
  return !error && value.is_object() ? std::move(value.get_object()) : json::object();
}

Exit run_detached(const std::string& log,
                  const std::function<Exit(const std::function<void()>& ready)>& work) {
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

EventLines::EventLines(Context& context, std::string_view schema, int subject_width)
    : context_(context), schema_(schema), subject_width_(subject_width), began_(tims::os::now()) {}

void EventLines::begin() { began_ = tims::os::now(); }

void EventLines::say(std::string_view event, std::string_view subject,
                     std::string_view text) const {
  const double t = base::seconds(tims::os::now() - began_);
  if (context_.out.json())
    return context_.out.write(json::object{{"schema", schema_},
                                           {"time", base::rfc3339(tims::os::wall_now())},
                                           {"t_s", t},
                                           {"event", event},
                                           {"subject", subject},
                                           {"text", text}});
  if (context_.options.quiet) return;
  context_.out.write(fmt::format("{:8.2f} s  {:<{}} {}\n", t, subject, subject_width_,
                                 base::printable_lines(text)));
}

}  // namespace timsctl
