// The two tasks of a component: who gives commands, and who does the work.
#include <algorithm>
#include <mutex>

#include "components/runtime/clock.h"
#include "components/runtime/module.h"
#include "os/clock.h"

namespace rack {
namespace {

constexpr tims::Duration kCommandWait = std::chrono::milliseconds(500);

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
    case tims::type::kGetStatus:
      return reply(header, static_cast<std::int8_t>(status()));
    case tims::type::kGetParam:
      return reply(header, tims::type::kParam, parameter_list());
    case tims::type::kGetRuntime:
      return reply(header, tims::type::kRuntime, runtime_data());
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
    return reply(message.header, tims::type::kError);
  }
  bool good = true;
  for (const Parameter& record : list->parameters) {
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
      log_.print("Module on");
      tell_status("on");
      break;
    case Kind::kOff:
      turned_off();
      module_off();
      log_.print("Module off");
      tell_status("off");
      break;
    case Kind::kCannotTurnOn:
      log_.print("Error, can't turn on module: %s", why->message());
      tell_status("error", why);
      turned_off();
      module_off();
      break;
    case Kind::kError:
      log_.print("Error: %s", why->message());
      tell_status("error", why);
      turned_off();
      module_off();
      break;
  }
  if (change.request) reply(*change.request, change.answer);
}

void Module::tell_status(std::string_view status, const tims::Error* why) {
  if (!manager_.listens()) return;
  std::string text = "STATUS=" + std::string(status);
  if (why != nullptr) text += ": " + why->message();
  std::ranges::replace(text, '\n', ' ');  // each line has a name
  manager_.tell(text);
}

}  // namespace rack
