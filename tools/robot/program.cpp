#include "tools/robot/program.h"

#include <algorithm>
#include <array>
#include <cstring>

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "os/service_manager.h"
#include "os/socket.h"
#include "tools/cli/failure.h"

namespace timsctl::robot {

namespace {

constexpr int kCannotExecute = 127;  // as in shells

// Whether the component is on or, with "error: ..." and "waiting: ...", tries to be.
bool should_be_on(std::string_view status) {
  return status == "on" || status.starts_with("error") || status.starts_with("waiting");
}

constexpr std::size_t kTextMax = 4096;  // the rest of a longer notification is ignored
constexpr int kNotificationsPerTurn = 64;
// More than the connection has room for: what a program has sent before its end.
constexpr int kNotificationsAtEnd = 10'000;

// The text after `name` at the start of a line.
std::optional<std::string_view> value_of(std::string_view text, std::string_view name) {
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    if (line.starts_with(name)) return line.substr(name.size());
    text.remove_prefix(std::min(line.size() + 1, text.size()));
  }
  return std::nullopt;
}

}  // namespace

Program::Program(std::string name, Launch launch, Config config)
    : name_(std::move(name)),
      launch_(std::move(launch)),
      config_(std::move(config)),
      policy_(config_.restart) {}

void Program::start(tims::Time now) {
  Launch launch = launch_;
  for (const auto& options : {parameters_, state_to_keep_})
    for (const auto& [name, value] : options)
      launch.command.push_back(fmt::format("--{}={}", name, value));
  if (should_be_on(status_)) launch.command.emplace_back("--targetStatus=1");
  tims::os::Pipe out = value_or_fail(tims::os::make_pipe(), "pipe");
  launch.out = out.write.get();
  tims::os::RecordPair connection =
      value_or_fail(tims::os::make_record_pair(), "connection for notifications");
  launch.inherited = connection.other.get();
  launch.environment.push_back(
      fmt::format("{}={}", tims::os::ServiceManager::kConnectionVariable,
                  tims::os::ServiceManager::connection_text(launch.inherited)));
  tims::os::Pipe in;
  if (!config_.input.empty()) {
    in = value_or_fail(tims::os::make_pipe(), "pipe");
    // Fits into the buffer of the pipe: this does not block.
    [[maybe_unused]] const ssize_t n =
        ::write(in.write.get(), config_.input.data(), config_.input.size());
    launch.in = in.read.get();
  }
  child_.start(launch);
  input_ = std::move(in.write);
  connection_ = std::move(connection.one);
  previous_output_ = std::exchange(output_, ProgramOutput(std::move(out.read)));
  state_ = config_.notifies ? State::kStarting : State::kReady;
  status_.clear();
  started_ = now;
  start_at_ = tims::kNever;
}

void Program::on_notification(std::string_view text) {
  if (is_ready_notification(text)) state_ = State::kReady;
  if (auto address = address_in(text)) address_ = std::move(*address);
  if (auto status = status_in(text)) status_ = std::move(*status);
  if (auto setting = setting_in(text, kParameterKey))
    parameters_[setting->name] = std::move(setting->value);
  if (auto setting = setting_in(text, kStateKey)) {
    if (setting->value.empty()) {
      state_to_keep_.erase(setting->name);
    } else {
      state_to_keep_[setting->name] = std::move(setting->value);
    }
  }
}

bool Program::take_notifications() { return take_notifications(kNotificationsPerTurn); }

bool Program::take_notifications(int most) {
  std::array<std::byte, kTextMax> text{};
  for (int taken = 0; taken < most; ++taken) {
    if (!connection_) return taken > 0;
    const auto record = tims::os::receive_record(connection_.get(), text, false);
    if (!record && record.error().code() == tims::Errc::kEmpty) return taken > 0;
    if (!record || record->size == 0) {  // all processes that had it are gone
      connection_.reset();
    } else {
      on_notification({reinterpret_cast<const char*>(text.data()), record->size});
    }
  }
  return true;
}

std::vector<int> Program::descriptors(tims::Time now) const {
  std::vector<int> all;
  if (child_.runs()) all.push_back(child_.descriptor());
  if (connection_) all.push_back(connection_.get());
  for (const ProgramOutput* output : {&previous_output_, &output_})
    if (const int pipe = output->descriptor(now); pipe >= 0) all.push_back(pipe);
  return all;
}

tims::Time Program::look_again_at(tims::Time now) const {
  tims::Time next = gate_.report_at();
  for (const ProgramOutput* output : {&previous_output_, &output_})
    if (output->rests_until() > now) next = std::min(next, output->rests_until());
  return next;
}

std::optional<Program::End> Program::ended(tims::Time now) {
  const auto status = child_.take_end();
  if (!status) return std::nullopt;
  input_.reset();
  take_notifications(kNotificationsAtEnd);
  return end_with(*status, now, now - started_);
}

Program::End Program::could_not_start(tims::Time now) {
  return end_with({.code = kCannotExecute}, now, {});
}

Program::End Program::end_with(tims::os::ExitStatus status, tims::Time now, tims::Duration ran) {
  state_ = State::kDown;
  const End end{.status = status, .pause = policy_.ended(status.as_shell(), ran)};
  start_at_ = end.pause ? now + *end.pause : tims::kNever;
  return end;
}

std::vector<std::string> Program::take_lines(tims::Time now) {
  std::vector<std::string> lines;
  previous_output_.read(now, gate_, lines);
  output_.read(now, gate_, lines);
  if (const auto held_back = gate_.take_report(now))
    lines.push_back(fmt::format("{} lines are not shown: it prints more than {} lines a second",
                                *held_back, kLinesPerSecond));
  return lines;
}

std::optional<tims::Duration> RestartPolicy::ended(int status, tims::Duration ran) {
  if (when_ == Restart::kNever || status == kUsage) return std::nullopt;
  if (when_ == Restart::kOnFailure && status == 0) return std::nullopt;
  if (ran >= kStableAfter) pause_ = kFirstPause;
  const tims::Duration pause = pause_;
  pause_ = std::min(2 * pause_, kLongestPause);
  return pause;
}

StatusSocket::StatusSocket(std::string path)
    : path_(std::move(path)),
      socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path_.size() >= sizeof address.sun_path)
    throw Failure(Exit::kDenied, "path", path_ + ": too long for the path of a socket");
  std::memcpy(address.sun_path, path_.data(), path_.size());
  ::unlink(path_.c_str());  // the listener at the control socket owns the folder, so a leftover can
                            // be removed
  const int yes = 1;
  if (::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::chmod(path_.c_str(), 0600) != 0 ||
      ::setsockopt(socket_.get(), SOL_SOCKET, SO_PASSCRED, &yes, sizeof yes) != 0)
    throw Failure(Exit::kDenied, "system", tims::os::system_error(path_).message());
}

StatusSocket::~StatusSocket() { ::unlink(path_.c_str()); }

std::optional<StatusSocket::Notification> StatusSocket::take() {
  std::array<char, kTextMax> text{};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(ucred))> control{};
  iovec whole{text.data(), text.size()};
  msghdr message{};
  message.msg_iov = &whole;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const ssize_t size = ::recvmsg(socket_.get(), &message, 0);
  if (size < 0) return std::nullopt;
  Notification notification{.text = {text.data(), static_cast<std::size_t>(size)}};
  const cmsghdr* sender = CMSG_FIRSTHDR(&message);
  if (sender != nullptr && sender->cmsg_level == SOL_SOCKET &&
      sender->cmsg_type == SCM_CREDENTIALS) {
    ucred peer{};
    std::memcpy(&peer, CMSG_DATA(sender), sizeof peer);
    notification.pid = peer.pid;
  }
  return notification;
}

std::optional<std::string> status_in(std::string_view text) {
  const auto value = value_of(text, "STATUS=");
  if (!value) return std::nullopt;
  return std::string(*value);
}

std::optional<std::string> address_in(std::string_view text) {
  const auto value = value_of(text, "X_TIMS_ADDRESS=");
  if (!value) return std::nullopt;
  return std::string(*value);
}

std::optional<Setting> setting_in(std::string_view text, std::string_view what) {
  const auto setting = value_of(text, what);
  const std::size_t equals = setting ? setting->find('=') : std::string_view::npos;
  if (equals == std::string_view::npos) return std::nullopt;
  return Setting{std::string(setting->substr(0, equals)), std::string(setting->substr(equals + 1))};
}

bool is_ready_notification(std::string_view text) { return value_of(text, "READY=") == "1"; }

}  // namespace timsctl::robot
