// The C API of the runtime: a Module whose virtual functions are callbacks.
#include <algorithm>
#include <atomic>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "rack.h"
#include "rack/clock.h"
#include "rack/data_module.h"
#include "rack/partner.h"

using rack::Result;
using tims::Errc;
using tims::Error;

// What both kinds of modules have for the functions of rack.h. A data set of a module without data
// is refused, so they are not told apart.
struct rack_module {
  rack_module() = default;
  rack_module(const rack_module&) = delete;
  rack_module& operator=(const rack_module&) = delete;
  virtual ~rack_module() = default;

  virtual std::int32_t get_integer(std::string_view name) = 0;
  virtual float get_real(std::string_view name) = 0;
  virtual std::string get_text(std::string_view name) = 0;
  virtual void set(std::string_view name, std::int32_t value) = 0;
  virtual void set(std::string_view name, std::string_view value) = 0;
  virtual rack::TextLog& text_log() = 0;
  virtual rack::Module& module() = 0;
  virtual bool answer(const tims::Header& request, std::int8_t type,
                      std::span<const std::byte> body) = 0;
  virtual Result<void> defer(const tims::MessageView& command,
                             std::function<Result<void>(const tims::Header&)> work) = 0;
  virtual bool on() = 0;
  virtual bool wanted() = 0;
  virtual void sleep() = 0;
  virtual void new_period(std::chrono::milliseconds period) = 0;
  virtual std::chrono::milliseconds present_period() = 0;
  virtual Result<void> publish_data(rack::TimeStamp recorded, std::span<const std::byte> body) = 0;

  std::string router;
  struct Partner {
    std::string name;
    std::unique_ptr<rack::PartnerBase> base;
  };
  std::vector<Partner> partners;
};

namespace {

// Why the last callback of this thread failed: a C function has no other place to return a text.
thread_local Error last_error = Errc::kInvalidArgument;

int code_of(const Error& error) { return -1 - static_cast<int>(error.code()); }

// The code is returned by a callback, the text was noted by rack_fail().
Result<void> outcome(int code) {
  if (code == 0) return {};
  return std::exchange(last_error, Error(Errc::kInvalidArgument, "it failed without a reason"));
}

tims_header c_header(const tims::Header& h) {
  return {h.dest.raw(), h.src.raw(), h.length, h.flags, h.type, h.priority, h.seq_nr};
}

tims::Header header_of(const tims_header& h) {
  tims::Header header;
  header.dest = tims::Address(h.dest);
  header.src = tims::Address(h.src);
  header.length = h.length;
  header.flags = h.flags;
  header.type = h.type;
  header.priority = h.priority;
  header.seq_nr = h.seq_nr;
  return header;
}

std::string_view text_or_nothing(const char* text) { return text == nullptr ? "" : text; }

// --- what ModuleInfo refers to, while the program runs

rack::ParameterInfo parameter_of(const rack_parameter& given) {
  const bool is_free = given.min == 0 && given.max == 0;
  const std::string_view help = text_or_nothing(given.help);
  rack::ParameterInfo info;
  if (given.kind == RACK_PARTNER) {
    info = rack::partner(given.name, text_or_nothing(given.text), help);
    info.initial = static_cast<std::int32_t>(given.number);
    info.min = given.min;
  } else {
    info.name = given.name;
    info.help = help;
    if (given.kind == RACK_INTEGER) info.initial = static_cast<std::int32_t>(given.number);
    if (given.kind == RACK_REAL) info.initial = static_cast<float>(given.number);
    if (given.kind == RACK_TEXT) info.initial = text_or_nothing(given.text);
    if (given.kind == RACK_REAL && is_free) {
      info.min = std::numeric_limits<float>::lowest();
      info.max = std::numeric_limits<float>::max();
    }
    if (!is_free) {
      info.min = given.min;
      info.max = given.max;
    }
  }
  info.required = given.required != 0;
  info.is_host_file = given.is_host_file != 0;
  info.takes_effect = static_cast<rack::TakesEffect>(given.takes_effect);
  return info;
}

struct Declared {
  explicit Declared(const rack_component& given) {
    for (std::size_t i = 0; i < given.parameter_count; ++i)
      parameters.push_back(parameter_of(given.parameters[i]));
    own_class = {given.class_id, text_or_nothing(given.class_name), {}};
    info.program = given.program;
    info.purpose = text_or_nothing(given.purpose);
    info.class_id = given.class_id;
    info.parameters = parameters;
    if (given.command_slots > 0) info.command_slots = given.command_slots;
    if (given.command_body_max > 0) info.command_body_max = given.command_body_max;
    if (given.class_name != nullptr) info.own_class = &own_class;
  }
  Declared(const Declared&) = delete;
  Declared& operator=(const Declared&) = delete;
  ~Declared() = default;

  std::vector<rack::ParameterInfo> parameters;
  rack::ClassInfo own_class;
  rack::ModuleInfo info;
};

rack::DataInfo data_info(const rack_component& given) {
  rack::DataInfo data;
  if (given.history > 0) data.history = given.history;
  if (given.listeners > 0) data.listeners = given.listeners;
  data.size_max = given.data_max;
  data.samples = given.no_samples == 0;
  return data;
}

// --- the module

class NamedPartner : public rack::PartnerBase {
 public:
  NamedPartner(rack::Module& module, std::uint32_t class_id, std::string_view name,
               const rack::OwnMailbox& work)
      : PartnerBase(module, class_id, name, work) {}
};

template <typename Base>
class Callbacks : public Base, public rack_module {
 public:
  template <typename... Args>
  explicit Callbacks(const rack_component& given, const Args&... args)
      : Base(args...), given_(given) {
    for (std::size_t i = 0; i < given.parameter_count; ++i) {
      const rack_parameter& row = given.parameters[i];
      if (row.kind != RACK_PARTNER) continue;
      partners.push_back(
          {row.name, std::make_unique<NamedPartner>(*this, row.class_id, row.name, no_mailbox())});
    }
    if (given.between != nullptr) around_.resize(3 * std::size_t{given.data_max});
  }

  std::int32_t get_integer(std::string_view name) override { return this->integer(name); }
  float get_real(std::string_view name) override { return this->real(name); }
  std::string get_text(std::string_view name) override { return this->text(name); }
  void set(std::string_view name, std::int32_t value) override { this->set_parameter(name, value); }
  void set(std::string_view name, std::string_view value) override {
    this->set_parameter(name, value);
  }
  rack::TextLog& text_log() override { return this->log(); }
  rack::Module& module() override { return *this; }
  bool answer(const tims::Header& request, std::int8_t type,
              std::span<const std::byte> body) override {
    return this->reply(request, type, body);
  }
  Result<void> defer(const tims::MessageView& command,
                     std::function<Result<void>(const tims::Header&)> work) override {
    return this->later(command, std::move(work));
  }
  bool on() override { return this->is_on(); }
  bool wanted() override { return this->is_wanted(); }
  void sleep() override { this->sleep_until_next(present_period()); }
  void new_period(std::chrono::milliseconds period) override {
    period_ms_ = period.count();
    if constexpr (kHasData) this->set_period(period);
  }
  std::chrono::milliseconds present_period() override {
    return std::chrono::milliseconds(std::max<std::int64_t>(period_ms_.load(), 1));
  }
  Result<void> publish_data(rack::TimeStamp recorded, std::span<const std::byte> body) override {
    if constexpr (kHasData) {
      if (body.size() > given_.data_max)
        return this->refused("the data have " + std::to_string(body.size()) +
                             " bytes, allowed are " + std::to_string(given_.data_max));
      std::ranges::copy(body, this->workspace().begin());
      this->publish(recorded, body.size());
      return {};
    } else {
      return this->refused("the component has no data: data_max is 0");
    }
  }

 protected:
  Result<void> module_init() override {
    return given_.init == nullptr ? Result<void>() : outcome(given_.init(this, given_.user));
  }
  void module_cleanup() override {
    if (given_.cleanup != nullptr) given_.cleanup(this, given_.user);
  }
  Result<void> module_on() override {
    if (given_.on != nullptr) {
      if (auto on = outcome(given_.on(this, given_.user)); !on) return on;
    }
    return Base::module_on();
  }
  void module_off() override {
    if (given_.off != nullptr) given_.off(this, given_.user);
  }
  Result<void> module_loop() override { return outcome(given_.loop(this, given_.user)); }
  Result<void> module_command(const tims::MessageView& message) override {
    if constexpr (kHasData) {
      if (message.header.type == tims::type::kGetData && given_.between != nullptr)
        return get_data_between(message);
    }
    if (given_.command == nullptr || message.header.type < rack::kFirstCommand)
      return Base::module_command(message);
    const tims_header header = c_header(message.header);
    return outcome(
        given_.command(this, &header, message.body.data(), message.body.size(), given_.user));
  }

 private:
  static constexpr bool kHasData = std::is_base_of_v<rack::DataModuleBase, Base>;

  // GET_DATA with a time. The callback is called without the mutex, on copies: it may take a lock
  // that another task holds while that waits for the mutex, as the one of Python's interpreter.
  Result<void> get_data_between(const tims::MessageView& message)
    requires kHasData
  {
    const auto request = rack::decode<rack::GetDataRequest>(message);
    if (!request || request->recordingTime.raw() == 0 || !this->is_on())
      return Base::module_command(message);
    rack_data_set before{};
    rack_data_set after{};
    if (auto copied = copy_around(request->recordingTime, before, after); !copied)
      return copied.error();
    if (after.body == nullptr) return Base::module_command(message);
    std::byte* const to = around_.data() + 2 * std::size_t{given_.data_max};
    const std::int64_t size =
        given_.between(this, request->recordingTime.raw(), &before, &after, to, given_.user);
    if (size < 0) return outcome(static_cast<int>(size));
    if (size > given_.data_max)
      return this->refused("its interpolated data are larger than data_max");
    this->reply(message.header, tims::type::kData, std::span(to, static_cast<std::size_t>(size)));
    return {};
  }

  // Nothing in `after`: the nearest data set is the answer.
  Result<void> copy_around(rack::TimeStamp time, rack_data_set& before, rack_data_set& after)
    requires kHasData
  {
    const std::lock_guard lock(this->mutex_);
    const rack::DataHistory& history = this->history();
    if (history.size() < 2) return {};
    if (given_.ahead == 0 && time - history.newest().recorded >= std::chrono::milliseconds(0))
      return {};
    const auto found = history.around(time, std::chrono::milliseconds(given_.ahead));
    if (const auto* miss = std::get_if<rack::DataHistory::Miss>(&found))
      return this->not_there(*miss, time);
    const auto& pair = std::get<rack::DataHistory::Pair>(found);
    before = copied(pair.before, around_.data());
    after = copied(pair.after, around_.data() + given_.data_max);
    return {};
  }

  static rack_data_set copied(const rack::DataHistory::Entry& entry, std::byte* to) {
    std::ranges::copy(entry.body, to);
    return {entry.recorded.raw(), to, entry.body.size()};
  }

  // A partner wants one. Calls are made by mailboxes of the program's own session, with local ids
  // above.
  const rack::OwnMailbox& no_mailbox() {
    if (!no_mailbox_) no_mailbox_.emplace(*this, 1, 0);
    return *no_mailbox_;
  }

  const rack_component& given_;
  std::optional<rack::OwnMailbox> no_mailbox_;
  std::atomic<std::int64_t> period_ms_ = 1000;
  std::vector<std::byte> around_;  // of the command task: two data sets, and what is between them
};

// The value of the last --router, as the module's own arguments.
std::string router_of(int argc, char** argv) {
  std::string router;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    const std::size_t dashes = std::min(argument.find_first_not_of('-'), argument.size());
    const std::string_view text = argument.substr(dashes);
    if (text.starts_with("router=")) router = text.substr(7);
    if (text == "router" && i + 1 < argc) router = argv[++i];
  }
  return router;
}

template <typename Kind>
int run(Kind& module, int argc, char** argv) {
  module.router = router_of(argc, argv);
  return static_cast<rack::Module&>(module).run(argc, argv);
}

const rack::Parameters::Entry* declared(rack_module* module, const char* name) {
  for (const auto& entry : module->module().parameters().entries())
    if (entry.info->name == name) return &entry;
  return nullptr;
}

bool is_of(const rack::Parameters::Entry* entry, std::size_t kind) {
  return entry != nullptr && entry->info->initial.index() == kind;
}

int note(rack_module* module, const Result<void>& result) {
  return result ? 0 : rack_fail(module, code_of(result.error()), result.error().detail().c_str());
}

}  // namespace

int rack_run(const rack_component* component, int argc, char** argv) {
  const Declared declared(*component);
  if (component->data_max == 0) {
    Callbacks<rack::Module> module(*component, declared.info);
    return run(module, argc, argv);
  }
  const rack::DataInfo data = data_info(*component);
  Callbacks<rack::DataModuleBase> module(*component, declared.info, data);
  return run(module, argc, argv);
}

void rack_stop(rack_module* module) { module->module().stop(); }

int rack_fail(rack_module*, int code, const char* text) {
  constexpr int kLast = static_cast<int>(Errc::kDiskFull);
  const int errc =
      code < 0 && -1 - code <= kLast ? -1 - code : static_cast<int>(Errc::kInvalidArgument);
  last_error = Error(static_cast<Errc>(errc), std::string(text_or_nothing(text)));
  return -1 - errc;
}

int rack_unknown_command(rack_module* module) {
  return rack_fail(module, TIMS_EINVALID, "unknown command");
}

// --- parameters

int32_t rack_integer(rack_module* module, const char* name) {
  return is_of(declared(module, name), rack::Parameter::kInt) ? module->get_integer(name) : 0;
}

float rack_real(rack_module* module, const char* name) {
  return is_of(declared(module, name), rack::Parameter::kFloat) ? module->get_real(name) : 0;
}

size_t rack_text(rack_module* module, const char* name, char* buffer, size_t size) {
  const bool is_text = is_of(declared(module, name), rack::Parameter::kString);
  const std::string text = is_text ? module->get_text(name) : std::string();
  if (size > 0) {
    const size_t n = std::min(size - 1, text.size());
    std::memcpy(buffer, text.data(), n);
    buffer[n] = 0;
  }
  return text.size();
}

int rack_set_integer(rack_module* module, const char* name, int32_t value) {
  if (!is_of(declared(module, name), rack::Parameter::kInt)) return TIMS_EINVALID;
  module->set(name, value);
  return 0;
}

int rack_set_text(rack_module* module, const char* name, const char* value) {
  if (!is_of(declared(module, name), rack::Parameter::kString)) return TIMS_EINVALID;
  module->set(name, text_or_nothing(value));
  return 0;
}

void rack_log(rack_module* module, int level, const char* text) {
  const auto known = rack::gdos::level_of_parameter(std::clamp(level, 0, 4));
  module->text_log().write(known, "{}", text_or_nothing(text));
}

// --- addresses and answers

uint32_t rack_address(rack_module* module) { return module->module().address().raw(); }

const char* rack_router(rack_module* module) {
  return module->router.empty() ? nullptr : module->router.c_str();
}

int rack_partner(rack_module* module, const char* name, uint32_t* address) {
  for (const auto& partner : module->partners) {
    if (partner.name != name) continue;
    const auto there = partner.base->address();
    if (!there) return rack_fail(module, TIMS_ENO_MAILBOX, "its instance is -1: there is none");
    *address = there->raw();
    return 0;
  }
  return rack_fail(module, TIMS_EINVALID, "there is no such partner among the parameters");
}

int rack_reply(rack_module* module, const tims_header* request, int8_t type, const void* body,
               size_t size) {
  const std::span bytes(static_cast<const std::byte*>(body), size);
  return module->answer(header_of(*request), type, bytes) ? 0 : TIMS_ENO_MAILBOX;
}

int rack_later(rack_module* module, const tims_header* request,
               int (*work)(rack_module*, const tims_header*, void*), void (*release)(void*),
               void* data) {
  const std::shared_ptr<void> kept(data, [release](void* gone) {
    if (release != nullptr) release(gone);
  });
  const auto added =
      module->defer({header_of(*request), {}}, [module, work, kept](const tims::Header& header) {
        const tims_header of = c_header(header);
        return outcome(work(module, &of, kept.get()));
      });
  return note(module, added);
}

int rack_is_on(rack_module* module) { return module->on() ? 1 : 0; }
int rack_is_wanted(rack_module* module) { return module->wanted() ? 1 : 0; }

// --- data

uint32_t rack_time_stamp() { return rack::time_stamp().raw(); }

void rack_set_period(rack_module* module, uint32_t period_ms) {
  module->new_period(std::chrono::milliseconds(period_ms));
}

uint32_t rack_period(rack_module* module) {
  return static_cast<uint32_t>(module->present_period().count());
}

void rack_sleep_until_next(rack_module* module) { module->sleep(); }

int rack_publish(rack_module* module, uint32_t recorded, const void* body, size_t size) {
  const std::span bytes(static_cast<const std::byte*>(body), size);
  return note(module, module->publish_data(rack::TimeStamp(recorded), bytes));
}
