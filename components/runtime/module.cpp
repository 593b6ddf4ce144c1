#include "components/runtime/module.h"

#include <poll.h>
#include <sys/signalfd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <random>

#include "components/runtime/core/arguments.h"
#include "components/runtime/thread.h"
#include "os/clock.h"
#include "os/event_fd.h"

namespace rack {
namespace {

constexpr tims::Duration kCommandWait = std::chrono::milliseconds(500);
constexpr std::uint32_t kLocalMax = 255;

sigset_t end_signals() {
  sigset_t set;
  ::sigemptyset(&set);
  ::sigaddset(&set, SIGTERM);
  ::sigaddset(&set, SIGINT);
  return set;
}

int fail(std::string_view program, const tims::Error& error, ExitCode code) {
  const std::string text =
      error.code() == tims::Errc::kInvalidArgument ? error.detail() : error.message();
  std::fprintf(stderr, "%s: %s\n", std::string(program).c_str(), text.c_str());
  return static_cast<int>(code);
}

}  // namespace

Module::Module(const ModuleInfo& info)
    : info_(info), parameters_(info.program, info.parameters), log_(gdos::Level::kWarning) {}

Module::~Module() = default;

// --- a program's life

int Module::run(int argc, char** argv) {
  return run(std::span<const char* const>(argv, static_cast<std::size_t>(argc)).subspan(1));
}

int Module::run(std::span<const char* const> arguments) {
  const auto parsed = parse_arguments(arguments, parameters_);
  if (!parsed) return fail(info_.program, parsed.error(), ExitCode::kUsage);
  if (parsed->help) {
    std::fputs(usage(parameters_, info_.purpose).c_str(), stdout);
    return static_cast<int>(ExitCode::kGood);
  }
  const auto started = start(parsed->router);
  if (started) {
    wait_for_end();
    end();
    return static_cast<int>(ExitCode::kGood);
  }
  end();
  return fail(info_.program, started.error(), ExitCode::kFailed);
}

Result<void> Module::start(const std::string& router) {
  // Before any thread is there, so that all of them leave these signals to the main thread.
  const sigset_t signals = end_signals();
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  auto stop = tims::os::make_event_fd();
  if (!stop) return stop.error();
  stop_ = std::move(*stop);
  log_.set_threshold(gdos::level_of_parameter(parameters_.integer("gdosLevel")));

  auto session = tims::Session::connect({.name = parameters_.program(), .router = router});
  if (!session) return session.error();
  session_.emplace(std::move(*session));
  address_ = address_of(info_.class_id, parameters_.integer("system"),
                        parameters_.integer("instance"));
  auto mailbox = session_->open(
      {.address = address_,
       .slots = info_.command_slots,
       .body_max = info_.command_body_max,
       .priority = static_cast<std::uint8_t>(parameters_.integer("dataTaskPrio"))});
  if (!mailbox) return mailbox.error();
  command_mailbox_.emplace(std::move(*mailbox));
  log_.print("Init");
  if (const auto ready = module_init(); !ready) return ready;
  return start_tasks();
}

Result<void> Module::start_tasks() {
  const std::int32_t retry = parameters_.integer("errorTimeout");
  std::optional<tims::Duration> error_retry;
  if (retry >= 0) error_retry = std::chrono::milliseconds(retry);
  cycle_.emplace(error_retry, std::random_device()());
  if (parameters_.integer("targetStatus") != 0) cycle_->turn_on();

  const int command_priority = parameters_.integer("cmdTaskPrio");
  const int data_priority = parameters_.integer("dataTaskPrio");
  if (std::max(command_priority, data_priority) > 1) {
    if (const auto locked = lock_memory(); !locked) log_.warning("%s", locked.error().detail());
  }
  const auto start_task = [&](std::optional<Thread>& thread, const char* letter, int priority,
                              void (Module::*task)()) -> Result<void> {
    ThreadSettings settings{.name = parameters_.program().substr(0, 14) + letter,
                            .priority = priority,
                            .cpu = parameters_.integer("cpu")};
    const auto body = [this, task] { (this->*task)(); };
    auto started = thread.emplace().start(settings, body);
    if (started) return {};
    log_.warning("%s: an ordinary one will do", started.error().detail());
    settings.priority = 0;
    return thread->start(settings, body);
  };
  if (const auto good = start_task(command_thread_, "C", command_priority, &Module::command_task);
      !good)
    return good;
  return start_task(data_thread_, "D", data_priority, &Module::data_task);
}

void Module::wait_for_end() {
  const sigset_t signals = end_signals();
  const tims::os::File signal(::signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK));
  std::array<pollfd, 3> wait{{{signal.get(), POLLIN, 0},
                              {stop_.get(), POLLIN, 0},
                              {log_.descriptor(), POLLIN, 0}}};
  while (wait[0].revents == 0 && wait[1].revents == 0) {
    log_.pass_on(tims::os::now(), *command_mailbox_);
    if (::poll(wait.data(), wait.size(), -1) < 0 && errno != EINTR) break;
  }
  signalfd_siginfo info;
  while (::read(signal.get(), &info, sizeof info) > 0) {
  }
}

void Module::stop() {
  if (stop_) tims::os::signal_event_fd(stop_.get());
}

void Module::end() {
  {
    const std::lock_guard lock(mutex_);
    stopping_.store(true, std::memory_order_relaxed);
  }
  commanded_.notify_all();
  // Wakes the command task; answers to nobody.
  if (command_mailbox_) (void)command_mailbox_->send({.dest = address_, .type = tims::type::kOk});
  command_thread_.reset();
  data_thread_.reset();
  if (!command_mailbox_) return;
  module_cleanup();
  log_.print("Terminated");
  log_.pass_on(tims::os::now(), *command_mailbox_);
}

// --- the command task

void Module::command_task() {
  while (!is_stopping()) {
    const auto message = command_mailbox_->peek_for(kCommandWait);
    if (message) {
      on_command({message->header(), message->body()});
    } else if (message.error().code() != tims::Errc::kTimeout) {
      log_.error("Error, no commands: %s", message.error().message());
      return stop();
    }
  }
}

void Module::on_command(const tims::MessageView& message) {
  const tims::Header& header = message.header;
  switch (header.type) {
    case tims::type::kOn: {
      std::optional<std::int8_t> answer;
      {
        const std::lock_guard lock(mutex_);
        answer = cycle_->turn_on(header);
      }
      commanded_.notify_all();
      if (answer) reply(header, *answer);
      return;
    }
    case tims::type::kOff: {
      std::optional<tims::Header> unanswered;
      {
        const std::lock_guard lock(mutex_);
        unanswered = cycle_->turn_off();
      }
      commanded_.notify_all();
      reply(header, tims::type::kOk);
      if (unanswered) reply(*unanswered, tims::type::kError);
      return;
    }
    case tims::type::kGetStatus: {
      const std::lock_guard lock(mutex_);
      return reply(header, static_cast<std::int8_t>(cycle_->status()));
    }
    case tims::type::kGetParam: {
      ParameterList list;
      {
        const std::lock_guard lock(mutex_);
        list = parameters_.list();
      }
      return reply(header, tims::type::kParam, list);
    }
    case tims::type::kSetParam:
      return set_parameters(message);
    default:
      break;
  }
  if (const auto done = module_command(message); !done && header.type > 0) {
    log_.warning("Command %i from %n: %s", header.type, header.src, done.error().message());
    reply(header, tims::type::kError);
  }
}

Result<void> Module::module_command(const tims::MessageView&) {
  return tims::Error(tims::Errc::kInvalidArgument, "not known here");
}

// Takes what is good of a list, and says what is not.
void Module::set_parameters(const tims::MessageView& message) {
  const auto list = decode<ParameterList>(message.body, message.header.body_order());
  bool good = list.ok();
  if (!list) log_.error("Parameters from %n: %s", message.header.src, list.error().message());
  for (const Parameter& record : good ? list->parameters : Sequence<Parameter, 128>()) {
    Result<bool> set = false;
    {
      const std::lock_guard lock(mutex_);
      set = parameters_.set(record);
      if (set) log_.set_threshold(gdos::level_of_parameter(parameters_.integer("gdosLevel")));
    }
    if (!set) log_.error("%s", set.error().detail());
    good = good && set.ok();
  }
  reply(message.header, good ? tims::type::kOk : tims::type::kError);
}

void Module::reply(const tims::Header& request, std::int8_t type, std::span<const std::byte> body) {
  // Who has gone meanwhile needs no answer.
  (void)command_mailbox_->reply(request, type, body);
}

// --- the data task

void Module::data_task() {
  std::unique_lock lock(mutex_);
  while (!is_stopping()) {
    const LifeCycle::Step step = cycle_->next(tims::os::now());
    if (step == LifeCycle::Step::kWait) {
      const tims::Time until = cycle_->wait_until();
      if (until == tims::kNever) {
        commanded_.wait(lock);
      } else {
        commanded_.wait_for(lock, until - tims::os::now());
      }
      continue;
    }
    lock.unlock();
    take_step(step);
    lock.lock();
  }
  const bool on = cycle_->status() == Status::kEnabled;
  lock.unlock();
  if (on) take_step(LifeCycle::Step::kTurnOff);
}

void Module::take_step(LifeCycle::Step step) {
  LifeCycle::Change change;
  Result<void> result;
  if (step == LifeCycle::Step::kTurnOn) {
    next_period_ = {};
    result = module_on();
    const std::lock_guard lock(mutex_);
    change = cycle_->turned_on(tims::os::now(), result.ok());
  } else if (step == LifeCycle::Step::kLoop) {
    result = module_loop();
    const std::lock_guard lock(mutex_);
    change = cycle_->looped(tims::os::now(), result.ok());
  } else {
    const std::lock_guard lock(mutex_);
    change = cycle_->turned_off();
  }
  apply(change, result ? nullptr : &result.error());
}

void Module::apply(const LifeCycle::Change& change, const tims::Error* why) {
  using Kind = LifeCycle::Change::Kind;
  // The graphical interface of the original knows these words.
  switch (change.kind) {
    case Kind::kNone:
      break;
    case Kind::kOn:
      log_.print("Module on");
      break;
    case Kind::kOff:
      turned_off();
      module_off();
      log_.print("Module off");
      break;
    case Kind::kCannotTurnOn:
      log_.print("Error, can't turn on module: %s", why->message());
      turned_off();
      module_off();
      break;
    case Kind::kError:
      log_.print("Error: %s", why->message());
      turned_off();
      module_off();
      break;
  }
  if (change.request) reply(*change.request, change.answer);
}

void Module::sleep_until_next(tims::Duration period) {
  const tims::Time now = tims::os::now();
  if (next_period_ == tims::Time{}) next_period_ = now;
  next_period_ += period;
  if (next_period_ < now) next_period_ += (now - next_period_) / period * period + period;
  const timespec until = tims::os::to_timespec(next_period_);
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

// --- what a component uses

std::int32_t Module::integer(std::string_view name) const {
  const std::lock_guard lock(mutex_);
  return parameters_.integer(name);
}

float Module::real(std::string_view name) const {
  const std::lock_guard lock(mutex_);
  return parameters_.real(name);
}

std::string Module::text(std::string_view name) const {
  const std::lock_guard lock(mutex_);
  return parameters_.text(name);
}

bool Module::is_on() const {
  const std::lock_guard lock(mutex_);
  return cycle_->status() == Status::kEnabled;
}

tims::Address Module::address_of(std::uint32_t class_id, std::int32_t system,
                                 std::int32_t instance) const {
  return tims::Address::of({.system = static_cast<std::uint32_t>(system),
                            .class_id = class_id,
                            .instance = static_cast<std::uint32_t>(instance)},
                           session_->address_widths());
}

tims::Address Module::component_of(tims::Address mailbox) const {
  auto fields = mailbox.fields(session_->address_widths());
  fields.local = 0;
  return tims::Address::of(fields, session_->address_widths());
}

Result<tims::Mailbox*> Module::create_mailbox(std::uint32_t slots, std::uint32_t body_max) {
  if (last_local_ == kLocalMax)
    return tims::Error(tims::Errc::kInvalidArgument, "a component has at most 255 mailboxes");
  auto fields = address_.fields(session_->address_widths());
  fields.local = ++last_local_;
  auto mailbox = session_->open(
      {.address = tims::Address::of(fields, session_->address_widths()),
       .slots = slots,
       .body_max = body_max,
       .priority = static_cast<std::uint8_t>(parameters_.integer("dataTaskPrio"))});
  if (!mailbox) return mailbox.error();
  return &mailboxes_.emplace_back(std::move(*mailbox));
}

}  // namespace rack
