#include "rack/module.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <random>

#include <poll.h>
#include <sys/signalfd.h>

#include "components/runtime/crash.h"
#include "components/runtime/logic/arguments.h"
#include "components/runtime/logic/description.h"
#include "components/runtime/logic/life_cycle.h"
#include "components/runtime/logic/repeats.h"
#include "components/runtime/real_time_watch.h"
#include "components/runtime/worker.h"
#include "os/clock.h"
#include "os/environment.h"
#include "os/file.h"
#include "os/service_manager.h"
#include "os/wakeup.h"
#include "rack/clock.h"
#include "rack/proxies/catalogue.h"
#include "rack/thread.h"
#include "tims/mailbox.h"
#include "tims/origin.h"
#include "tims/session.h"

namespace rack {
namespace {

constexpr tims::Duration kRouterWait = std::chrono::seconds(2);  // long enough for a slow network
constexpr tims::Duration kCommandWait = std::chrono::milliseconds(500);
// In this time after the start of a program, partners that do not exist yet are waited for.
constexpr tims::Duration kPartnersCome = std::chrono::seconds(10);
// How long the answer to OFF may wait until the supervisor has taken the OFF.
constexpr tims::Duration kHeldWait = std::chrono::milliseconds(50);
constexpr int kReportEach =
    250;  // ms; the main thread polls, so that a real-time task need not wake it

constexpr std::string_view kStateVariable = "X_TIMS_STATE=";

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

// The text of an error; refusals of the component itself have no prefix.
std::string text_of(const tims::Error& error) {
  return error.code() == tims::Errc::kInvalidArgument && !error.detail().empty() ? error.detail()
                                                                                 : error.message();
}

// Class ids of components begin at Test.
LifeCycle::By commanded_by(tims::Address program, const tims::AddressWidths& widths) {
  return program.fields(widths).class_id < tims::class_id::kTest ? LifeCycle::By::kOperator
                                                                 : LifeCycle::By::kComponent;
}

std::string name_of_command(std::uint32_t class_id, std::int8_t type) {
  const MessageInfo* info = find_message(class_id, type);
  return info != nullptr ? std::string(info->name) : "Command " + std::to_string(type);
}

// Whether the sender of a command waits for a reason: not a program of the original.
bool knows_reasons(const tims::Header& request) {
  return (request.flags & tims::flag::kReportReason) != 0 ||
         (request.type == tims::type::kOn &&
          request.length >= tims::kHeaderSize + wire_size<OnRequest>());
}

LifeCycle::Turned turned(const Result<void>& result) {
  if (result) return LifeCycle::Turned::kOn;
  return result.error().code() == tims::Errc::kNoMailbox ? LifeCycle::Turned::kPartnerIsMissing
                                                         : LifeCycle::Turned::kFailed;
}

int fail(std::string_view program, const tims::Error& error, ExitCode code) {
  std::fprintf(stderr, "%s: %s\n", std::string(program).c_str(), text_of(error).c_str());
  return static_cast<int>(code);
}

}  // namespace

// The runtime of a module, hidden from derived classes. Two threads share it; members protected by
// the module's mutex_ are marked.
class [[gnu::visibility("hidden")]] Module::Runtime {
 public:
  explicit Runtime(Module& module)
      : module_(module),
        info_(module.info_),
        parameters_(module.parameters_),
        log_(module.log_),
        mutex_(module.mutex_),
        manager_(tims::os::ServiceManager::of_environment()) {}

  Result<void> start(const Arguments& arguments);
  void wait_for_end();
  void end();
  void notify(std::string_view what, std::string_view name, const std::string& value);
  [[nodiscard]] Status status() const;
  [[nodiscard]] bool wants_on() const;
  void take_result(const tims::Header& request, const Result<void>& done);

  tims::Address address_{};
  std::optional<tims::Session> session_;
  std::optional<tims::Mailbox> command_mailbox_;
  std::deque<tims::Mailbox> mailboxes_;
  std::uint32_t last_local_ = 0;
  tims::Time next_period_{};
  std::atomic<bool> stopping_ = false;
  tims::os::File stop_;  // eventfd
  std::optional<Worker> worker_;

 private:
  Result<void> connect(const std::string& router);
  Result<void> start_tasks(std::optional<tims::Address> held_off_by);

  void command_task();
  void on_command(const tims::MessageView& message);
  void describe(const tims::MessageView& message);
  void set_parameters(const tims::MessageView& message);
  void answer_status(const tims::Header& request);
  void turn_on(const tims::Header& request);
  void turn_off(const tims::Header& request);
  void refuse(const tims::Header& request, std::string_view why);
  void report_held(std::optional<tims::Address> by);
  [[nodiscard]] std::string why_not_on() const;
  [[nodiscard]] ParameterList parameter_list() const;
  [[nodiscard]] RuntimeData runtime_data() const;

  void data_task();
  void take_step(LifeCycle::Step step);
  void apply(const LifeCycle::Change& change, const tims::Error* why);
  void report_failure(const char* what, const std::string& why);
  void report_settled();
  void report_status(std::string_view status, const tims::Error* why = nullptr);
  Result<void> watched_loop();

  Module& module_;
  const ModuleInfo& info_;
  Parameters& parameters_;
  TextLog& log_;
  PriorityMutex& mutex_;
  tims::os::ServiceManager manager_;

  std::optional<LifeCycle> cycle_;         // protected by mutex_
  std::string why_in_error_;               // protected by mutex_
  std::condition_variable_any commanded_;  // used with mutex_
  std::atomic<TimeStamp> state_since_ = TimeStamp(0);
  RealTimeWatch watch_;  // watches the data task
  FailureLog failures_;  // used by the data task
  RefusalLog refusals_;  // protected by mutex_
  std::optional<Thread> command_thread_;
  std::optional<Thread> data_thread_;
};

Module::Module(const ModuleInfo& info)
    : info_(info),
      parameters_(info.program, info.parameters),
      log_(gdos::Level::kWarning),
      runtime_(std::make_unique<Runtime>(*this)) {}

Module::~Module() = default;

// --- life cycle of the program

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
  if (parsed->describe) {
    if (info_.own_class != nullptr) (void)add_class(*info_.own_class);  // for its name
    std::fputs(description().c_str(), stdout);
    return static_cast<int>(ExitCode::kGood);
  }
  if (const auto report = run_alone()) {
    if (!*report) return fail(info_.program, report->error(), ExitCode::kFailed);
    std::fputs((*report)->text.c_str(), stdout);
    return static_cast<int>((*report)->code);
  }
  const auto started = runtime_->start(*parsed);
  if (started) {
    if (runtime_->session_) runtime_->wait_for_end();
    runtime_->end();
    return static_cast<int>(ExitCode::kGood);
  }
  runtime_->end();
  return fail(info_.program, started.error(), ExitCode::kFailed);
}

Result<void> Module::Runtime::start(const Arguments& arguments) {
  if (info_.own_class != nullptr) {
    if (auto added = add_class(*info_.own_class); !added) return added;
  }
  // Blocked before any thread is started, so that the main thread gets these signals.
  const sigset_t signals = end_signals();
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  auto stop = tims::os::make_event_fd();
  if (!stop) return stop.error();
  stop_ = std::move(*stop);
  log_.set_threshold(gdos::level_of_parameter(parameters_.integer("gdosLevel")));

  if (auto connected = connect(arguments.router); !connected) return connected;
  if (!session_) return {};  // stopped before there was a router
  log_.set_widths(module_.address_widths());
  if (auto fit = parameters_.set_widths(module_.address_widths()); !fit) return fit;
  if (const int bits = module_.address_widths().class_id; info_.class_id >> bits != 0)
    return refused("class " + std::to_string(info_.class_id) + " does not fit into the " +
                   std::to_string(bits) + " bits that the addresses of this fleet have for it");
  address_ = module_.address_of(info_.class_id, parameters_.integer("system"),
                                parameters_.integer("instance"));
  auto mailbox =
      session_->open({.address = address_,
                      .slots = info_.command_slots,
                      .body_max = info_.command_body_max,
                      .priority = static_cast<std::uint8_t>(parameters_.integer("dataTaskPrio"))});
  if (!mailbox) return mailbox.error();
  command_mailbox_.emplace(std::move(*mailbox));
  log_.print("Init");
  if (auto ready = module_.module_init(); !ready) return ready;
  if (auto created = module_.create_own_mailboxes(); !created) return created;
  if (auto tasks = start_tasks(arguments.held_off_by); !tasks) return tasks;
  manager_.report("READY", "1\nX_TIMS_ADDRESS=" + address_.to_hex());
  return {};
}

// Waits until there is a router, or until the program is stopped.
Result<void> Module::Runtime::connect(const std::string& router) {
  auto reported = std::make_shared<std::atomic<bool>>(false);
  const auto report_once = [reported,
                            program = parameters_.program()](const tims::SessionEvent& event) {
    const bool waiting = event.kind == tims::SessionEvent::Kind::kWaiting;
    const bool worth = event.kind != tims::SessionEvent::Kind::kConnected;
    if (worth && !(waiting && reported->exchange(true)))
      std::fprintf(stderr, "%s: %s\n", program.c_str(), event.text.c_str());
    if (!waiting) reported->store(false);
  };
  // Messages of a real-time task must not wait for an ordinary thread.
  const int priority =
      std::max(parameters_.integer("cmdTaskPrio"), parameters_.integer("dataTaskPrio"));
  while (!session_ && !end_is_wanted()) {
    auto session =
        tims::Session::connect({.name = parameters_.program(),
                                .router = router,
                                .timeout = kRouterWait,
                                .tcp_priority = priority >= kFirstRealTime ? priority : 0,
                                .on_event = report_once});
    if (session) {
      session_.emplace(std::move(*session));
    } else if (session.error().code() != tims::Errc::kTimeout) {
      return session.error();
    }
  }
  return {};
}

Result<void> Module::Runtime::start_tasks(std::optional<tims::Address> held_off_by) {
  const std::int32_t retry = parameters_.integer("errorTimeout");
  std::optional<tims::Duration> error_retry;
  if (retry >= 0) error_retry = std::chrono::milliseconds(retry);
  cycle_.emplace(error_retry, std::random_device()());
  cycle_->wait_for_partners(tims::os::deadline_after(kPartnersCome));
  if (held_off_by) {
    cycle_->hold_off(*held_off_by);
  } else if (parameters_.integer("targetStatus") != 0) {
    cycle_->turn_on();
  }
  state_since_ = time_stamp();

  const int command_priority = parameters_.integer("cmdTaskPrio");
  const int data_priority = parameters_.integer("dataTaskPrio");
  if (std::max(command_priority, data_priority) >= kFirstRealTime) {
    if (const auto locked = lock_memory(); !locked) log_.warning("{}", locked.error().detail());
  }
  const auto start_task = [&](std::optional<Thread>& thread, const char* letter, int priority,
                              void (Runtime::*task)()) -> Result<void> {
    ThreadSettings settings{.name = parameters_.program().substr(0, 14) + letter,
                            .priority = priority,
                            .cpu = parameters_.integer("cpu")};
    const auto body = [this, task] { (this->*task)(); };
    auto started = thread.emplace().start(settings, body);
    if (started) return {};
    log_.warning("{}: using an ordinary thread", started.error().detail());
    settings.priority = 0;
    return thread->start(settings, body);
  };
  worker_.emplace(parameters_.program().substr(0, 14) + "W");
  if (auto good = start_task(command_thread_, "C", command_priority, &Runtime::command_task); !good)
    return good;
  return start_task(data_thread_, "D", data_priority, &Runtime::data_task);
}

void Module::Runtime::wait_for_end() {
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
  if (runtime_->stop_) tims::os::signal_event_fd(runtime_->stop_.get());
}

void Module::Runtime::end() {
  {
    const std::lock_guard lock(mutex_);
    stopping_.store(true, std::memory_order_relaxed);
  }
  commanded_.notify_all();
  // Wakes the command task; has no receiver for an answer.
  if (command_mailbox_) (void)command_mailbox_->send({.dest = address_, .type = tims::type::kOk});
  command_thread_.reset();
  if (worker_)
    for (const tims::Header& request : worker_->stop())
      refuse(request, "the component is stopping");
  data_thread_.reset();
  if (!command_mailbox_) return;
  module_.module_cleanup();
  log_.print("Terminated");
  log_.pass_on(tims::os::now(), *command_mailbox_);
}

// --- used by a component

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

void Module::set_parameter(std::string_view name, std::string_view value) {
  const std::lock_guard lock(mutex_);
  if (!parameters_.set(name, value)) (void)parameters_.set(name, "");
}

tims::Address Module::address() const { return runtime_->address_; }

tims::Mailbox& Module::command_mailbox() { return *runtime_->command_mailbox_; }

tims::AddressWidths Module::address_widths() const { return runtime_->session_->address_widths(); }

bool Module::is_stopping() const { return runtime_->stopping_.load(std::memory_order_relaxed); }

bool Module::is_wanted() const { return !is_stopping() && runtime_->wants_on(); }

bool Module::is_on() const { return runtime_->status() == Status::kEnabled; }

tims::Address Module::address_of(std::uint32_t class_id, std::int32_t system,
                                 std::int32_t instance) const {
  return tims::Address::of({.system = static_cast<std::uint32_t>(system),
                            .class_id = class_id,
                            .instance = static_cast<std::uint32_t>(instance)},
                           runtime_->session_->address_widths());
}

tims::Address Module::component_of(tims::Address mailbox) const {
  auto fields = mailbox.fields(runtime_->session_->address_widths());
  fields.local = 0;
  return tims::Address::of(fields, runtime_->session_->address_widths());
}

std::string Module::description() const {
  std::vector<UsedComponent> inputs;
  inputs.reserve(partners_.size());
  for (const PartnerNames& partner : partners_)
    inputs.push_back(
        {.class_id = partner.class_id, .system = partner.system, .instance = partner.instance});
  return rack::description(parameters_, {.purpose = info_.purpose,
                                         .class_id = info_.class_id,
                                         .inputs = inputs,
                                         .has_data = has_data()});
}

Result<void> Module::create_own_mailboxes() {
  for (OwnMailbox* own : own_mailboxes_) {
    if (runtime_->last_local_ + 1 >= std::uint64_t{1} << address_widths().local)
      return refused("the addresses of this fleet have no free local id for another mailbox");
    auto fields = runtime_->address_.fields(address_widths());
    fields.local = ++runtime_->last_local_;
    auto mailbox = runtime_->session_->open(
        {.address = tims::Address::of(fields, address_widths()),
         .slots = own->slots_,
         .body_max = std::max<std::uint32_t>(own->body_max_, kReasonMax),
         .priority = static_cast<std::uint8_t>(parameters_.integer("dataTaskPrio"))});
    if (!mailbox) return mailbox.error();
    own->mailbox_ = &runtime_->mailboxes_.emplace_back(std::move(*mailbox));
  }
  return {};
}

OwnMailbox::OwnMailbox(Module& owner, std::uint32_t slots, std::uint32_t body_max)
    : slots_(slots), body_max_(body_max) {
  owner.own_mailboxes_.push_back(this);
}

bool Module::reply(const tims::Header& request, std::int8_t type, std::span<const std::byte> body) {
  return runtime_->command_mailbox_->reply(request, type, body).ok();
}

tims::Time Module::sleep_until_next(tims::Duration period) {
  const tims::Time now = tims::os::now();
  if (runtime_->next_period_ == tims::Time{}) runtime_->next_period_ = now;
  runtime_->next_period_ += period;
  if (runtime_->next_period_ < now)
    runtime_->next_period_ += (now - runtime_->next_period_) / period * period + period;
  const timespec until = tims::os::to_timespec(runtime_->next_period_);
  const tims::Waiting waiting;
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
  return runtime_->next_period_;
}

Result<tims::Mailbox> Module::open_mailbox(const tims::MailboxOptions& options) {
  return runtime_->session_->open(options);
}

// --- the command task

void Module::Runtime::command_task() {
  while (!module_.is_stopping()) {
    const bool reported = manager_.flush();
    const auto message =
        command_mailbox_->peek_for(reported ? kCommandWait : tims::os::ServiceManager::kFlushPause);
    if (message) {
      on_command({message->header(), message->body()});
    } else if (message.error().code() != tims::Errc::kTimeout) {
      log_.error("Error, no commands: {}", message.error().message());
      return module_.stop();
    }
  }
}

void Module::Runtime::on_command(const tims::MessageView& message) {
  const tims::Header& header = message.header;
  switch (header.type) {
    case tims::type::kOn:
      return turn_on(header);
    case tims::type::kOff:
      return turn_off(header);
    case tims::type::kGetStatus:
      return answer_status(header);
    case tims::type::kGetParam:
      return module_.reply(header, tims::type::kParam, parameter_list());
    case tims::type::kGetParamEffects:
      return module_.reply(header, tims::type::kParamEffects, parameters_.effects());
    case tims::type::kGetDescription:
      return describe(message);
    case tims::type::kGetRuntime:
      return module_.reply(header, tims::type::kRuntime, runtime_data());
    case tims::type::kSetParam:
      return set_parameters(message);
    default:
      break;
  }
  take_result(header, module_.module_command(message));
}

Result<void> Module::later(const tims::MessageView& command, Work work) {
  return runtime_->worker_->add(
      command.header, [runtime = runtime_.get(), request = command.header, work = std::move(work)] {
        runtime->take_result(request, work(request));
      });
}

// A reason is written once and then counted. Requests to a component that is off are normal, for
// example from graphical interfaces.
void Module::Runtime::take_result(const tims::Header& request, const Result<void>& done) {
  if (done || request.type <= 0) return;
  const std::string why = text_of(done.error());
  refuse(request, why);
  const std::string what = name_of_command(info_.class_id, request.type);
  if (!module_.is_on()) return log_.info("{} from {}: {}", what, request.src, why);
  RefusalLog::Verdict verdict;
  {
    const std::lock_guard lock(mutex_);
    verdict = refusals_.take(tims::os::now(), request, why);
  }
  if (!verdict.write) return;
  if (verdict.repeats == 0) return log_.warning("{} from {}: {}", what, request.src, why);
  log_.warning("{} from {}: {} ({} more times since)", what, request.src, why, verdict.repeats);
}

// Who asks later than it was logged, or where there is no log, is told as well why it is in error.
void Module::Runtime::answer_status(const tims::Header& request) {
  std::unique_lock lock(mutex_);
  const Status now = cycle_->status();
  if (now != Status::kError) {
    lock.unlock();
    return void(module_.reply(request, static_cast<std::int8_t>(now)));
  }
  const std::string why = why_in_error_;
  lock.unlock();
  refuse(request, why);
}

void Module::Runtime::turn_on(const tims::Header& request) {
  std::optional<std::int8_t> answer;
  std::string why;
  bool was_held = false;
  bool is_held = false;
  {
    const std::lock_guard lock(mutex_);
    was_held = cycle_->held_off_by().has_value();
    answer = cycle_->turn_on(tims::os::now(), request,
                             commanded_by(request.src, module_.address_widths()),
                             knows_reasons(request));
    is_held = cycle_->held_off_by().has_value();
    if (answer == tims::type::kError) why = why_not_on();
  }
  commanded_.notify_all();
  if (was_held && !is_held) report_held(std::nullopt);
  if (answer == tims::type::kError) return refuse(request, why);
  if (answer) module_.reply(request, *answer);
}

void Module::Runtime::turn_off(const tims::Header& request) {
  const LifeCycle::By by = commanded_by(request.src, module_.address_widths());
  std::vector<tims::Header> unanswered;
  {
    const std::lock_guard lock(mutex_);
    unanswered = cycle_->turn_off(request, by);
  }
  commanded_.notify_all();
  if (by == LifeCycle::By::kOperator) report_held(request.src);  // before the answer to OFF
  module_.reply(request, tims::type::kOk);
  for (const tims::Header& on : unanswered)
    refuse(on,
           request.src.to_string(module_.address_widths()) + " has turned it off before it was on");
}

// Answers with ERROR, with the reason if there is room.
void Module::Runtime::refuse(const tims::Header& request, std::string_view why) {
  const auto text = std::as_bytes(std::span(why.substr(0, kReasonMax)));
  if (knows_reasons(request) && module_.reply(request, tims::type::kError, text)) return;
  module_.reply(request, tims::type::kError);
}

// Reports the OFF to the supervisor, which keeps it when it restarts the program after a crash.
void Module::Runtime::report_held(std::optional<tims::Address> by) {
  manager_.report(std::string(kStateVariable).append(kHeldOffBy), by ? by->to_hex() : std::string(),
                  kHeldWait);
}

std::string Module::Runtime::why_not_on() const {
  const auto by = cycle_->held_off_by();
  if (!by) return "it is already being turned on";
  return by->to_string(module_.address_widths()) +
         " has turned it off; only an operator can turn it on again";
}

Result<void> Module::module_command(const tims::MessageView&) { return refused("unknown command"); }

bool Module::Runtime::wants_on() const {
  const std::lock_guard lock(mutex_);
  return cycle_->wants_on();
}

Status Module::Runtime::status() const {
  const std::lock_guard lock(mutex_);
  return cycle_->status();
}

ParameterList Module::Runtime::parameter_list() const {
  const std::lock_guard lock(mutex_);
  return parameters_.list();
}

// Takes no lock of the data task, so that the request does not disturb it.
RuntimeData Module::Runtime::runtime_data() const {
  RuntimeData data;
  data.since = state_since_.load();
  watch_.describe(data);
  return data;
}

// Declarations do not change while the program runs, so that its pages fit together.
void Module::Runtime::describe(const tims::MessageView& message) {
  const auto request = decode<DescriptionRequest>(message);
  if (!request) return refuse(message.header, request.error().message());
  const auto page = page_of(module_.description(), *request);
  if (!page) return refuse(message.header, page.error().detail());
  module_.reply(message.header, tims::type::kDescription, *page);
}

// Sets the valid parameters of a list, and logs the others.
void Module::Runtime::set_parameters(const tims::MessageView& message) {
  const auto list = decode<ParameterList>(message);
  if (!list) {
    log_.error("Parameters from {}: {}", message.header.src, list.error().message());
    return refuse(message.header, list.error().message());
  }
  std::string why;
  for (const Parameter& record : list->parameters) {
    Result<bool> set = false;
    std::string value;
    {
      const std::lock_guard lock(mutex_);
      set = parameters_.set(record, tims::is_foreign(message.header));
      if (set) log_.set_threshold(gdos::level_of_parameter(parameters_.integer("gdosLevel")));
      if (set && *set) value = parameters_.as_text(record.name.view());
    }
    if (set && *set) notify("X_TIMS_PARAMETER=", record.name.view(), value);
    if (set) continue;
    log_.error("{}", set.error().detail());
    if (why.empty()) why = set.error().detail();
  }
  if (!why.empty()) return refuse(message.header, why);
  module_.reply(message.header, tims::type::kOk);
}

// Reports a changed parameter to the supervisor, which restarts the program with it after a crash.
void Module::Runtime::notify(std::string_view what, std::string_view name,
                             const std::string& value) {
  if (value.find('\n') != std::string::npos) return;  // the protocol is one line per variable
  manager_.report(std::string(what).append(name), value);
}

void Module::report_state(std::string_view name, const std::string& value) const {
  runtime_->notify(kStateVariable, name, value);
}

// --- the data task

void Module::Runtime::data_task() {
  if (is_watched(parameters_.integer("dataTaskPrio"))) watch_.start(log_);
  std::unique_lock lock(mutex_);
  while (!module_.is_stopping()) {
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
  watch_.stop();
}

Result<void> Module::Runtime::watched_loop() {
  const RealTimeWatch::Section section(watch_);
  return module_.module_loop();
}

void Module::Runtime::take_step(LifeCycle::Step step) {
  LifeCycle::Change change;
  Result<void> result;
  if (step == LifeCycle::Step::kTurnOn) {
    next_period_ = {};
    result = module_.module_on();
    const std::lock_guard lock(mutex_);
    change = cycle_->turned_on(tims::os::now(), turned(result));
  } else if (step == LifeCycle::Step::kLoop) {
    result = watched_loop();
    report_settled();
    const std::lock_guard lock(mutex_);
    change = cycle_->looped(tims::os::now(), result.ok());
  } else {
    const std::lock_guard lock(mutex_);
    change = cycle_->turned_off();
  }
  if (change.kind != LifeCycle::Change::Kind::kNone) {
    state_since_ = time_stamp();
    const std::lock_guard lock(mutex_);
    why_in_error_ = result ? std::string() : text_of(result.error());
  }
  apply(change, result ? nullptr : &result.error());
}

void Module::Runtime::apply(const LifeCycle::Change& change, const tims::Error* why) {
  using Kind = LifeCycle::Change::Kind;
  // The graphical interface of the original recognises these texts.
  switch (change.kind) {
    case Kind::kNone:
      break;
    case Kind::kOn:
      if (failures_.turned_on(tims::os::now())) log_.print("Module on");
      report_status("on");
      break;
    case Kind::kOff:
      module_.turned_off();
      module_.module_off();
      failures_.turned_off();
      log_.print("Module off");
      report_status("off");
      break;
    case Kind::kWaits:
      log_.info("Waiting: {}", why->message());
      report_status("waiting", why);
      module_.turned_off();
      module_.module_off();
      break;
    case Kind::kCannotTurnOn:
    case Kind::kError:
      report_failure(change.kind == Kind::kError ? "Error" : "Error, can't turn on module",
                     why->message());
      report_status("error", why);
      module_.turned_off();
      module_.module_off();
      break;
  }
  for (const tims::Header& request : change.requests) {
    if (change.answer != tims::type::kError) {
      module_.reply(request, change.answer);
    } else {
      refuse(request, why != nullptr ? text_of(*why) : std::string());
    }
  }
}

// Reports a failure once while retries fail for the same reason. The graphical interface of the
// original looks for the short text, at the level that it knows.
void Module::Runtime::report_failure(const char* what, const std::string& why) {
  const bool ends = module_.is_stopping() || end_is_wanted();  // as the partners that it misses
  const bool is_new = !ends && failures_.failed(why);
  log_.write(is_new ? gdos::Level::kError : gdos::Level::kInfo, "{}", why);
  if (is_new) log_.print("{}", what);
}

// A component that failed again and again is reported to be on when it has been on for a while.
void Module::Runtime::report_settled() {
  const auto failures = failures_.settled(tims::os::now());
  if (!failures) return;
  if (*failures == 0)
    log_.print("Module on");
  else
    log_.print("Module on, after {} more failure{}", *failures, *failures == 1 ? "" : "s");
}

void Module::Runtime::report_status(std::string_view status, const tims::Error* why) {
  if (!manager_.listens()) return;
  std::string text(status);
  if (why != nullptr) text += ": " + why->message();
  std::ranges::replace(text, '\n', ' ');  // the protocol is one line per variable
  manager_.report("STATUS", text);
}

}  // namespace rack
