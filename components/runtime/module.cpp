#include "components/runtime/module.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <random>

#include <poll.h>
#include <sys/signalfd.h>

#include "components/runtime/clock.h"
#include "components/runtime/crash.h"
#include "components/runtime/thread.h"
#include "os/clock.h"
#include "os/event_fd.h"
#include "os/waiting.h"

namespace rack {
namespace {

constexpr tims::Duration kRouterWait = std::chrono::seconds(2);  // also over a slow network
constexpr int kReportEach = 250;  // ms; a real-time task does not stop to wake anybody

sigset_t end_signals() {
  sigset_t set;
  ::sigemptyset(&set);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) ::sigaddset(&set, signal);
  return set;
}

bool end_is_wanted() {
  sigset_t pending;
  ::sigpending(&pending);
  return ::sigismember(&pending, SIGTERM) == 1 || ::sigismember(&pending, SIGINT) == 1 ||
         ::sigismember(&pending, SIGHUP) == 1;
}

int fail(std::string_view program, const tims::Error& error, ExitCode code) {
  const std::string text =
      error.code() == tims::Errc::kInvalidArgument ? error.detail() : error.message();
  std::fprintf(stderr, "%s: %s\n", std::string(program).c_str(), text.c_str());
  return static_cast<int>(code);
}

}  // namespace

Module::Module(const ModuleInfo& info)
    : info_(info),
      parameters_(info.program, info.parameters),
      log_(gdos::Level::kWarning),
      manager_(tims::os::ServiceManager::of_environment()) {}

Module::~Module() = default;

// --- a program's life

int Module::run(int argc, char** argv) {
  return run(std::span<const char* const>(argv, static_cast<std::size_t>(argc)).subspan(1));
}

int Module::run(std::span<const char* const> arguments) {
  install_crash_report();
  const CrashStack crash_stack;
  const auto parsed = parse_arguments(arguments, parameters_);
  if (!parsed) return fail(info_.program, parsed.error(), ExitCode::kUsage);
  if (parsed->help) {
    std::fputs(usage(parameters_, info_.purpose).c_str(), stdout);
    return static_cast<int>(ExitCode::kGood);
  }
  if (parsed->version) {
    std::fputs((std::string(info_.program) + " " TIMS_VERSION "\n").c_str(), stdout);
    return static_cast<int>(ExitCode::kGood);
  }
  const auto started = start(*parsed);
  if (started) {
    if (session_) wait_for_end();
    end();
    return static_cast<int>(ExitCode::kGood);
  }
  end();
  return fail(info_.program, started.error(), ExitCode::kFailed);
}

Result<void> Module::start(const Arguments& arguments) {
  // Before any thread is there, so that all of them leave these signals to the main thread.
  const sigset_t signals = end_signals();
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  auto stop = tims::os::make_event_fd();
  if (!stop) return stop.error();
  stop_ = std::move(*stop);
  log_.set_threshold(gdos::level_of_parameter(parameters_.integer("gdosLevel")));

  if (auto connected = connect(arguments.router); !connected) return connected;
  if (!session_) return {};  // told to end before there was a router
  if (auto fit = parameters_.set_widths(address_widths()); !fit) return fit;
  address_ =
      address_of(info_.class_id, parameters_.integer("system"), parameters_.integer("instance"));
  auto mailbox =
      session_->open({.address = address_,
                      .slots = info_.command_slots,
                      .body_max = info_.command_body_max,
                      .priority = static_cast<std::uint8_t>(parameters_.integer("dataTaskPrio"))});
  if (!mailbox) return mailbox.error();
  command_mailbox_.emplace(std::move(*mailbox));
  log_.print("Init");
  if (auto ready = module_init(); !ready) return ready;
  if (auto tasks = start_tasks(arguments.held_off_by); !tasks) return tasks;
  manager_.tell("READY=1\nX_TIMS_ADDRESS=" + address_.to_hex());
  return {};
}

// Until there is a router, or somebody wants an end.
Result<void> Module::connect(const std::string& router) {
  auto said = std::make_shared<std::atomic<bool>>(false);
  const auto say_once = [said, program = parameters_.program()](const tims::SessionEvent& event) {
    const bool waiting = event.kind == tims::SessionEvent::Kind::kWaiting;
    const bool worth = event.kind != tims::SessionEvent::Kind::kConnected;
    if (worth && !(waiting && said->exchange(true)))
      std::fprintf(stderr, "%s: %s\n", program.c_str(), event.text.c_str());
    if (!waiting) said->store(false);
  };
  // What a real-time task sends waits for no ordinary thread.
  const int priority =
      std::max(parameters_.integer("cmdTaskPrio"), parameters_.integer("dataTaskPrio"));
  while (!session_ && !end_is_wanted()) {
    auto session =
        tims::Session::connect({.name = parameters_.program(),
                                .router = router,
                                .timeout = kRouterWait,
                                .tcp_priority = priority >= kFirstRealTime ? priority : 0,
                                .on_event = say_once});
    if (session) {
      session_.emplace(std::move(*session));
    } else if (session.error().code() != tims::Errc::kTimeout) {
      return session.error();
    }
  }
  return {};
}

Result<void> Module::start_tasks(std::optional<tims::Address> held_off_by) {
  const std::int32_t retry = parameters_.integer("errorTimeout");
  std::optional<tims::Duration> error_retry;
  if (retry >= 0) error_retry = std::chrono::milliseconds(retry);
  cycle_.emplace(error_retry, std::random_device()());
  if (held_off_by) {
    cycle_->hold_off(*held_off_by);
  } else if (parameters_.integer("targetStatus") != 0) {
    cycle_->turn_on();
  }
  state_since_ = time_stamp();

  const int command_priority = parameters_.integer("cmdTaskPrio");
  const int data_priority = parameters_.integer("dataTaskPrio");
  if (std::max(command_priority, data_priority) >= kFirstRealTime) {
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
  if (auto good = start_task(command_thread_, "C", command_priority, &Module::command_task); !good)
    return good;
  return start_task(data_thread_, "D", data_priority, &Module::data_task);
}

void Module::wait_for_end() {
  const sigset_t signals = end_signals();
  const tims::os::File signal(::signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK));
  std::array<pollfd, 3> wait{
      {{signal.get(), POLLIN, 0}, {stop_.get(), POLLIN, 0}, {log_.descriptor(), POLLIN, 0}}};
  while (wait[0].revents == 0 && wait[1].revents == 0) {
    watch_.report(log_);
    log_.pass_on(tims::os::now(), *command_mailbox_);
    const int patience_ms = watch_.on() ? kReportEach : -1;
    if (::poll(wait.data(), wait.size(), patience_ms) < 0 && errno != EINTR) break;
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

void Module::set_parameter(std::string_view name, std::int32_t value) {
  const std::lock_guard lock(mutex_);
  (void)parameters_.set(name, std::to_string(value));
}

bool Module::is_on() const { return status() == Status::kEnabled; }

tims::Address Module::address_of(std::uint32_t class_id, std::int32_t system,
                                 std::int32_t instance) const {
  return tims::Address::of({.system = static_cast<std::uint32_t>(system),
                            .class_id = class_id,
                            .instance = static_cast<std::uint32_t>(instance)},
                           session_->address_widths());
}

tims::Address Module::address_of(std::uint32_t class_id, std::string_view name) const {
  const std::string parameter(name);
  return address_of(class_id, integer(parameter + "Sys"), integer(parameter + "Inst"));
}

tims::Address Module::component_of(tims::Address mailbox) const {
  auto fields = mailbox.fields(session_->address_widths());
  fields.local = 0;
  return tims::Address::of(fields, session_->address_widths());
}

Result<tims::Mailbox*> Module::create_mailbox(std::uint32_t slots, std::uint32_t body_max) {
  if (last_local_ + 1 >= std::uint64_t{1} << address_widths().local)
    return refused("addresses here have no room for more mailboxes of a component");
  auto fields = address_.fields(session_->address_widths());
  fields.local = ++last_local_;
  auto mailbox =
      session_->open({.address = tims::Address::of(fields, session_->address_widths()),
                      .slots = slots,
                      .body_max = std::max<std::uint32_t>(body_max, kReasonMax),
                      .priority = static_cast<std::uint8_t>(parameters_.integer("dataTaskPrio"))});
  if (!mailbox) return mailbox.error();
  return &mailboxes_.emplace_back(std::move(*mailbox));
}

bool Module::reply(const tims::Header& request, std::int8_t type, std::span<const std::byte> body) {
  return command_mailbox_->reply(request, type, body).ok();
}

tims::Time Module::sleep_until_next(tims::Duration period) {
  const tims::Time now = tims::os::now();
  if (next_period_ == tims::Time{}) next_period_ = now;
  next_period_ += period;
  if (next_period_ < now) next_period_ += (now - next_period_) / period * period + period;
  const timespec until = tims::os::to_timespec(next_period_);
  const tims::os::Waiting waiting;
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
  return next_period_;
}

Result<tims::Mailbox> Module::open_mailbox(const tims::MailboxOptions& options) {
  return session_->open(options);
}

}  // namespace rack
