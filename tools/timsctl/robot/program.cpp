#include "tools/timsctl/robot/program.h"

#include <array>

#include <fcntl.h>
#include <unistd.h>

#include "os/file.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/robot/status_socket.h"

namespace timsctl::robot {

namespace {

constexpr int kCannotExecute = 127;  // as shells say it

// "on", and "error: ..." of a component that tries to be on.
bool wants_to_be_on(std::string_view status) {
  return status == "on" || status.starts_with("error");
}

}  // namespace

Program::Program(std::string name, Launch launch, Manner manner)
    : name_(std::move(name)),
      launch_(std::move(launch)),
      manner_(std::move(manner)),
      policy_(manner_.restart) {}

std::optional<pid_t> Program::pid() const {
  return child_ ? std::optional(child_->pid()) : std::nullopt;
}

void Program::start(tims::Time now) {
  Launch launch = launch_;
  for (const auto& options : {parameters_, kept_})
    for (const auto& [name, value] : options) launch.command.push_back("--" + name + "=" + value);
  if (wants_to_be_on(status_)) launch.command.emplace_back("--targetStatus=1");
  tims::os::Pipe out = value_or_fail(tims::os::make_pipe(), "pipe");
  launch.out = out.write.get();
  tims::os::Pipe in;
  if (!manner_.input.empty()) {
    in = value_or_fail(tims::os::make_pipe(), "pipe");
    // Less than a pipe holds: this never waits.
    [[maybe_unused]] const ssize_t n =
        ::write(in.write.get(), manner_.input.data(), manner_.input.size());
    launch.in = in.read.get();
  }
  child_ = Child::start(launch);
  input_ = std::move(in.write);
  output_ = std::move(out.read);
  ::fcntl(output_.get(), F_SETFL, O_NONBLOCK);
  state_ = manner_.tells ? State::kStarting : State::kReady;
  status_.clear();
  started_ = now;
  start_at_ = tims::kNever;
}

void Program::hear(std::string_view said) {
  if (says_ready(said)) state_ = State::kReady;
  if (auto address = address_in(said)) address_ = std::move(*address);
  if (auto status = status_in(said)) status_ = std::move(*status);
  if (auto told = told_in(said, kParameterTold)) parameters_[told->name] = std::move(told->value);
  if (auto told = told_in(said, kStateTold)) {
    if (told->value.empty()) {
      kept_.erase(told->name);
    } else {
      kept_[told->name] = std::move(told->value);
    }
  }
}

void Program::signal(int number) const {
  if (child_) child_->signal(number);
}

std::vector<int> Program::descriptors() const {
  if (!child_) return {};
  if (!output_) return {child_->descriptor()};
  return {child_->descriptor(), output_.get()};
}

std::optional<Program::End> Program::ended(tims::Time now) {
  if (!child_ || !child_->has_ended()) return std::nullopt;
  const int status = child_->reap();
  child_.reset();
  input_.reset();
  return end_with(status, now, now - started_);
}

Program::End Program::could_not_start(tims::Time now) { return end_with(kCannotExecute, now, {}); }

Program::End Program::end_with(int status, tims::Time now, tims::Duration ran) {
  state_ = State::kDown;
  const End end{.status = status, .pause = policy_.ended(status, ran)};
  start_at_ = end.pause ? now + *end.pause : tims::kNever;
  return end;
}

std::vector<std::string> Program::take_lines() {
  std::vector<std::string> lines;
  std::array<char, 4096> text{};
  ssize_t n = 0;
  while (output_ && (n = ::read(output_.get(), text.data(), text.size())) > 0) {
    auto more = lines_.add({text.data(), static_cast<std::size_t>(n)});
    lines.insert(lines.end(), std::make_move_iterator(more.begin()),
                 std::make_move_iterator(more.end()));
  }
  // Nobody writes there any more; or what still does is none of ours.
  if (output_ && (n == 0 || !child_)) output_.reset();
  if (output_) return lines;
  if (std::string rest = lines_.take_rest(); !rest.empty()) lines.push_back(std::move(rest));
  return lines;
}

}  // namespace timsctl::robot
