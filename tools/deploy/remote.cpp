#include "tools/deploy/remote.h"

#include <array>
#include <csignal>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include "tools/deploy/answers.h"

namespace timsctl::deploy {
namespace {

constexpr std::string_view kReady = "tims-deploy-ready";
constexpr std::size_t kErrorsMax = 64'000;  // bytes; what comes behind them is left out
constexpr int kSshFailed = 255;             // exit status of ssh for its own errors
constexpr tims::Duration kEndTime = std::chrono::seconds(2);

// Becomes root if it is not, and runs the script with its own text as first argument.
constexpr std::string_view kStart = R"sh([ "$(id -u)" != 0 ] || exec sh -c "$1" tims-deploy "$@"
why=$(LC_ALL=C sudo -n -- sh -c : 2>&1) && exec sudo -n -- sh -c "$1" tims-deploy "$@"
me=$(id -un)
printf 'tims-deploy: rights: %s is not root there, and cannot become it without a password (%s); ' "$me" "${why##*: }" >&2
printf 'as root there: echo "%s ALL=(ALL) NOPASSWD: ALL" >/etc/sudoers.d/%s\n' "$me" "$me" >&2
exit 10)sh";

tims::os::File memory_of(std::string_view text) {
  tims::os::File file(::memfd_create("stdin", MFD_CLOEXEC));
  while (file && !text.empty()) {
    const ssize_t n = ::write(file.get(), text.data(), text.size());
    if (n <= 0) throw Failure(Exit::kNo, "system", "no memory for what is sent");
    text.remove_prefix(static_cast<std::size_t>(n));
  }
  ::lseek(file.get(), 0, SEEK_SET);
  return file;
}

void end(Child& child) {
  if (!child.runs()) return;
  child.signal(SIGTERM);
  if (child.take_end(kEndTime)) return;
  child.signal(SIGKILL);
  (void)child.take_end(tims::Duration(std::chrono::hours(1)));
}

}  // namespace

std::string in_shell_quotes(std::string_view text) {
  std::string word = "'";
  for (const char c : text) {
    if (c == '\'')
      word += "'\\''";
    else
      word += c;
  }
  return word + "'";
}

Remote::Stream Remote::stream_of(tims::os::Pipe& pipe) {
  ::fcntl(pipe.read.get(), F_SETFL, O_NONBLOCK);
  return {.file = std::move(pipe.read)};
}

void Remote::Stream::read_into(std::string& text, std::size_t bytes_max) {
  std::array<char, 65536> buffer{};
  while (file) {
    const ssize_t n = ::read(file.get(), buffer.data(), buffer.size());
    if (n == 0) file.reset();
    if (n <= 0) return;
    const std::size_t room = bytes_max - std::min(bytes_max, text.size());
    text.append(buffer.data(), std::min(room, static_cast<std::size_t>(n)));
  }
}

// A shell there that reads until its stdin ends: it does when this process ends, however it does.
void Remote::connect() {
  disconnect();
  auto in = value_or_fail(tims::os::make_pipe(), "pipe");
  auto out = value_or_fail(tims::os::make_pipe(), "pipe");
  auto err = value_or_fail(tims::os::make_pipe(), "pipe");
  master_.start(
      {.command = {"ssh", "-M", "-S", socket_, "-T", "-oBatchMode=yes", "-oConnectTimeout=10",
                   "-oServerAliveInterval=5", "-oServerAliveCountMax=3", "-oControlPersist=no",
                   "-oClearAllForwardings=yes", "--", ssh_,
                   fmt::format("echo {}; exec cat", kReady)},
       .in = in.read.get(),
       .out = out.write.get(),
       .err = err.write.get()});
  hold_ = std::move(in.write);
  master_out_ = stream_of(out);
  master_err_ = stream_of(err);
}

// Without the connection the command fails, instead of making one of its own.
void Remote::run(const std::vector<std::string>& words, std::string_view input) {
  end_command();
  output_.clear();
  errors_.clear();
  std::string command =
      fmt::format("sh -c {} sh {}", in_shell_quotes(kStart), in_shell_quotes(kOnHost));
  for (const std::string& word : words) command += " " + in_shell_quotes(word);
  const auto in = memory_of(input);
  auto out = value_or_fail(tims::os::make_pipe(), "pipe");
  auto err = value_or_fail(tims::os::make_pipe(), "pipe");
  command_.start({.command = {"ssh", "-S", socket_, "-T", "-oBatchMode=yes", "-oControlMaster=no",
                              "-oProxyCommand=false", "--", ssh_, command},
                  .in = in.get(),
                  .out = out.write.get(),
                  .err = err.write.get()});
  out_ = stream_of(out);
  err_ = stream_of(err);
}

void Remote::end_command() {
  end(command_);
  out_ = {};
  err_ = {};
}

void Remote::disconnect() {
  end_command();
  hold_.reset();
  end(master_);
  master_out_ = {};
  master_err_ = {};
  greeting_.clear();
  master_errors_.clear();
  connected_ = false;
}

std::vector<int> Remote::descriptors() const {
  std::vector<int> all{master_.descriptor(), command_.descriptor()};
  for (const Stream* stream : {&master_out_, &master_err_, &out_, &err_})
    all.push_back(stream->file.get());
  return all;
}

Remote::Event Remote::take() {
  if (!connected_) master_out_.read_into(greeting_, kErrorsMax);
  std::string ignored;
  if (connected_) master_out_.read_into(ignored, 0);
  master_err_.read_into(master_errors_, kErrorsMax);
  out_.read_into(output_, kAnswerMax);
  err_.read_into(errors_, kErrorsMax);
  if (master_.take_end()) {
    const std::string why = master_errors_;
    disconnect();
    errors_ = why;
    return Event::kLost;
  }
  if (!connected_ && greeting_.find(kReady) != std::string::npos) {
    connected_ = true;
    return Event::kConnected;
  }
  const auto ended = command_.take_end();
  if (!ended) return Event::kNone;
  out_.read_into(output_, kAnswerMax);
  err_.read_into(errors_, kErrorsMax);
  out_ = {};
  err_ = {};
  status_ = ended->as_shell();
  if (status_ != kSshFailed) return Event::kEnded;
  const std::string why = errors_;
  disconnect();
  errors_ = why;
  return Event::kLost;
}

}  // namespace timsctl::deploy
