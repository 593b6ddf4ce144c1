// The two tasks of a component: who gives commands, and who does the work.
#include <algorithm>
#include <mutex>

#include "components/runtime/clock.h"
#include "components/runtime/module.h"
#include "os/clock.h"
#include "proxies/catalogue.h"

namespace rack {
namespace {

constexpr tims::Duration kCommandWait = std::chrono::milliseconds(500);

// What a component says itself needs no heading.
std::string words_of(const tims::Error& error) {
  return error.code() == tims::Errc::kInvalidArgument && !error.detail().empty() ? error.detail()
                                                                                 : error.message();
}

}  // namespace

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
    case tims::type::kOn:
      return turn_on(header);
    case tims::type::kOff:
      return turn_off(header);
    case tims::type::kGetStatus:
      reply(header, static_cast<std::int8_t>(status()));
      return;
    case tims::type::kGetParam:
      return reply(header, tims::type::kParam, parameter_list());
    case tims::type::kGetParamEffects:
      return reply(header, tims::type::kParamEffects, parameters_.effects());
    case tims::type::kGetRuntime:
      return reply(header, tims::type::kRuntime, runtime_data());
    case tims::type::kSetParam:
      return set_parameters(message);
    default:
      break;
  }
  const auto done = module_command(message);
  if (done || header.type <= 0) return;
  // Who looks at a component that is off, as windows do, disturbs nobody.
  log_.write(is_on() ? gdos::Level::kWarning : gdos::Level::kInfo, "%s from %n: %s",
             {name_of_command(header), header.src, words_of(done.error())});
  refuse(header, words_of(done.error()));
}

void Module::turn_on(const tims::Header& request) {
  std::optional<std::int8_t> answer;
  std::string why;
  bool was_held = false;
  bool is_held = false;
  {
    const std::lock_guard lock(mutex_);
    was_held = cycle_->held_off_by().has_value();
    answer = cycle_->turn_on(tims::os::now(), request, commanded_by(request.src));
    is_held = cycle_->held_off_by().has_value();
    if (answer == tims::type::kError) why = why_not_on();
  }
  commanded_.notify_all();
  if (was_held && !is_held) tell_held(std::nullopt);
  if (answer == tims::type::kError) return refuse(request, why);
  if (answer) reply(request, *answer);
}

void Module::turn_off(const tims::Header& request) {
  const LifeCycle::By by = commanded_by(request.src);
  std::optional<tims::Header> unanswered;
  {
    const std::lock_guard lock(mutex_);
    unanswered = cycle_->turn_off(request, by);
  }
  commanded_.notify_all();
  if (by == LifeCycle::By::kHand) tell_held(request.src);  // before anybody knows that it is off
  reply(request, tims::type::kOk);
  if (unanswered)
    refuse(*unanswered, request.src.to_string(address_widths()) + " has turned it off meanwhile");
}

// With ERROR, and in words when there is room for them.
void Module::refuse(const tims::Header& request, std::string_view why) {
  const bool has_room = (request.flags & tims::flag::kTellWhy) != 0 ||
                        (request.type == tims::type::kOn &&
                         request.length >= tims::kHeaderSize + wire_size<OnRequest>());
  const auto words = std::as_bytes(std::span(why.substr(0, kReasonMax)));
  if (has_room && reply(request, tims::type::kError, words)) return;
  reply(request, tims::type::kError);
}

// Whoever starts this program again after a crash leaves it off.
void Module::tell_held(std::optional<tims::Address> by) const {
  tell_state(kHeldOffBy, by ? by->to_hex() : std::string());
}

std::string Module::why_not_on() const {
  const auto by = cycle_->held_off_by();
  if (!by) return "it is being turned on already";
  return by->to_string(address_widths()) + " has turned it off, until it is turned on by hand";
}

// Classes of components begin at Test.
LifeCycle::By Module::commanded_by(tims::Address program) const {
  return program.fields(address_widths()).class_id < tims::class_id::kTest
             ? LifeCycle::By::kHand
             : LifeCycle::By::kComponent;
}

std::string Module::name_of_command(const tims::Header& header) const {
  const MessageInfo* info = find_message(info_.class_id, header.type);
  return info != nullptr ? std::string(info->name) : "Command " + std::to_string(header.type);
}

Result<void> Module::module_command(const tims::MessageView&) { return refused("not known here"); }

Status Module::status() const {
  const std::lock_guard lock(mutex_);
  return cycle_->status();
}

ParameterList Module::parameter_list() const {
  const std::lock_guard lock(mutex_);
  return parameters_.list();
}

// Takes no lock that the data task wants: to ask whether it is disturbed does not disturb it.
RuntimeData Module::runtime_data() const {
  RuntimeData data;
  data.since = state_since_.load();
  watch_.describe(data);
  return data;
}

// Takes what is good of a list, and says what is not.
void Module::set_parameters(const tims::MessageView& message) {
  const auto list = decode<ParameterList>(message);
  if (!list) {
    log_.error("Parameters from %n: %s", message.header.src, list.error().message());
    return refuse(message.header, list.error().message());
  }
  std::string why;
  for (const Parameter& record : list->parameters) {
    Result<bool> set = false;
    std::string value;
    {
      const std::lock_guard lock(mutex_);
      set = parameters_.set(record);
      if (set) log_.set_threshold(gdos::level_of_parameter(parameters_.integer("gdosLevel")));
      if (set && *set) value = parameters_.as_text(record.name.view());
    }
    if (set && *set) tell("X_TIMS_PARAMETER=", record.name.view(), value);
    if (set) continue;
    log_.error("%s", set.error().detail());
    if (why.empty()) why = set.error().detail();
  }
  if (!why.empty()) return refuse(message.header, why);
  reply(message.header, tims::type::kOk);
}

// Whoever starts this program again after a crash starts it with what was set meanwhile.
void Module::tell(std::string_view what, std::string_view name, const std::string& value) const {
  if (value.find('\n') != std::string::npos) return;  // each line of what is told has a name
  manager_.tell(std::string(what).append(name) + "=" + value);
}

void Module::tell_state(std::string_view name, const std::string& value) const {
  tell("X_TIMS_STATE=", name, value);
}

// --- the data task

void Module::data_task() {
  if (is_watched(parameters_.integer("dataTaskPrio"))) watch_.start(log_);
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
  watch_.stop();
}

Result<void> Module::watched_loop() {
  const RealTimeWatch::Section section(watch_);
  return module_loop();
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
    result = watched_loop();
    const std::lock_guard lock(mutex_);
    change = cycle_->looped(tims::os::now(), result.ok());
  } else {
    const std::lock_guard lock(mutex_);
    change = cycle_->turned_off();
  }
  if (change.kind != LifeCycle::Change::Kind::kNone) state_since_ = time_stamp();
  apply(change, result ? nullptr : &result.error());
}

void Module::apply(const LifeCycle::Change& change, const tims::Error* why) {
  using Kind = LifeCycle::Change::Kind;
  // The graphical interface of the original knows these words.
  switch (change.kind) {
    case Kind::kNone:
      break;
    case Kind::kOn:
      said_failed_.clear();
      log_.print("Module on");
      tell_status("on");
      break;
    case Kind::kOff:
      turned_off();
      module_off();
      said_failed_.clear();
      log_.print("Module off");
      tell_status("off");
      break;
    case Kind::kCannotTurnOn:
      say_failed("Error, can't turn on module", why->message());
      tell_status("error", why);
      turned_off();
      module_off();
      break;
    case Kind::kError:
      say_failed("Error", why->message());
      tell_status("error", why);
      turned_off();
      module_off();
      break;
  }
  if (!change.request) return;
  if (change.answer != tims::type::kError) {
    reply(*change.request, change.answer);
  } else {
    refuse(*change.request, why != nullptr ? words_of(*why) : std::string());
  }
}

// Once, however often it is tried again in vain for the same reason. The graphical interface of the
// original looks for the short text, which is of the level of all that it knows.
void Module::say_failed(const char* what, const std::string& why) {
  const bool again = why == said_failed_;
  said_failed_ = why;
  log_.write(again ? gdos::Level::kInfo : gdos::Level::kError, "%s", {why});
  if (!again) log_.print(what);
}

void Module::tell_status(std::string_view status, const tims::Error* why) {
  if (!manager_.listens()) return;
  std::string text = "STATUS=" + std::string(status);
  if (why != nullptr) text += ": " + why->message();
  std::ranges::replace(text, '\n', ' ');  // each line has a name
  manager_.tell(text);
}

}  // namespace rack
