// The base class of every component (specification, section 5).
//
//   class Sweeper : public rack::Module {
//    public:
//     Sweeper() : Module(kInfo) {}
//    private:
//     Result<void> module_on() override;    // acquires what it needs while on
//     Result<void> module_loop() override;  // called repeatedly while on
//     void module_off() override;           // also after one of the two has failed
//   };
//   int main(int argc, char** argv) {
//     Sweeper sweeper;
//     return sweeper.run(argc, argv);
//   }
//
// Two threads: the *command task* receives commands from the command mailbox and answers them; the
// *data task* turns the component on and off and calls module_loop(). The derived class must
// protect its members that both use; the runtime protects its own state.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rack/codec/codec.h"
#include "rack/parameters.h"
#include "rack/priority_mutex.h"
#include "rack/proxies/catalogue.h"
#include "rack/text_log.h"
#include "tims/mailbox.h"
#include "tims/time.h"

#pragma GCC visibility push(default)  // what librack.so shows
namespace rack {

// The description of a component's program.
struct ModuleInfo {
  std::string_view program;  // "ChassisSim"; also the first entry of its parameter list
  std::string_view purpose;  // for --help
  std::uint32_t class_id = 0;
  std::span<const ParameterInfo> parameters{};  // its own, and common ones with a different default
  std::uint32_t command_slots = 16;
  std::uint32_t command_body_max = 8192;  // enough for 47 parameters in one message
  const ClassInfo* own_class = nullptr;   // for a class outside of RACK: its messages
};

// Exit codes of run().
enum class ExitCode : int { kGood = 0, kFailed = 1, kUsage = 2 };

class OwnMailbox;

class Module {
 public:
  explicit Module(const ModuleInfo& info);  // which must outlive it
  Module(const Module&) = delete;
  Module& operator=(const Module&) = delete;
  virtual ~Module();

  // Runs the program: arguments, router, tasks, until SIGTERM, SIGINT, SIGHUP or stop(). Notifies a
  // service manager (sd_notify(3)) when it is ready, and of its status: on, off, error.
  int run(int argc, char** argv);
  int run(std::span<const char* const> arguments);
  void stop();  // from any thread

  [[nodiscard]] tims::Address address() const;
  [[nodiscard]] const Parameters& parameters() const { return parameters_; }

 protected:
  // --- overridden by a component

  // Called once before the tasks start and before the members OwnMailbox are created. An error ends
  // the program.
  virtual Result<void> module_init() { return {}; }
  virtual void module_cleanup() {}
  virtual Result<void> module_on() { return {}; }
  virtual void module_off() {}
  // Must return within the time that a user accepts for OFF. An error turns the component off, and
  // on again later.
  virtual Result<void> module_loop() = 0;
  // Handles a command that is not common to all components. An error is answered by ERROR. Called
  // by the command task.
  virtual Result<void> module_command(const tims::MessageView& message);
  // Runs without a router when a parameter requests it, and returns the output and exit code.
  // Nothing: normal operation.
  struct Report {
    ExitCode code = ExitCode::kGood;
    std::string text{};
  };
  virtual std::optional<Result<Report>> run_alone() { return {}; }

  // --- used by a component

  TextLog& log() { return log_; }
  // Any task: a copy of the current value of a parameter.
  [[nodiscard]] std::int32_t integer(std::string_view name) const;
  [[nodiscard]] float real(std::string_view name) const;
  [[nodiscard]] std::string text(std::string_view name) const;
  // Sets a parameter to a value that the component has determined; it must be in the allowed range.
  void set_parameter(std::string_view name, std::int32_t value);
  // A text longer than 79 bytes, the limit of parameters, becomes empty.
  void set_parameter(std::string_view name, std::string_view value);

  // Reports a state to the service manager, as the value that this parameter gets when the program
  // is restarted after a crash. The parameter itself does not change.
  void report_state(std::string_view name, const std::string& value) const;
  // Opens a mailbox at an address outside of this component. kAddressInUse: the text names the
  // owner. Any task.
  Result<tims::Mailbox> open_mailbox(const tims::MailboxOptions& options);
  [[nodiscard]] tims::Mailbox& command_mailbox();
  // The address of a component of this fleet, local id 0.
  [[nodiscard]] tims::Address address_of(std::uint32_t class_id, std::int32_t system,
                                         std::int32_t instance) const;
  [[nodiscard]] tims::AddressWidths address_widths() const;
  // The component that owns a mailbox: the address without its local id.
  [[nodiscard]] tims::Address component_of(tims::Address mailbox) const;

  // False: not delivered. A sender that no longer exists needs no answer.
  bool reply(const tims::Header& request, std::int8_t type, std::span<const std::byte> body = {});
  template <Struct Body>
  void reply(const tims::Header& request, std::int8_t type, const Body& body);
  // The result of module_command() for a command that is answered by OK when done.
  Result<void> answered(const tims::MessageView& command, Result<void> done) {
    if (done) reply(command.header, tims::type::kOk);
    return done;
  }
  // An error with the reason of a refusal.
  static tims::Error refused(std::string text) {
    return {tims::Errc::kInvalidArgument, std::move(text)};
  }

  [[nodiscard]] bool is_on() const;
  [[nodiscard]] bool is_stopping() const;
  // The component was not turned off and is not stopping: for a module_on() that waits.
  [[nodiscard]] bool is_wanted() const;
  // Called by the data task: sleeps until the next multiple of `period` since ON. Missed periods
  // are skipped. Returns that time.
  tims::Time sleep_until_next(tims::Duration period);

  // --- DataModule only: between a component and the runtime
  virtual void turned_off() {}  // before module_off()
  [[nodiscard]] virtual bool has_data() const { return false; }
  mutable PriorityMutex mutex_;  // protects the state of the runtime

 private:
  friend class OwnMailbox;
  friend class PartnerBase;
  class [[gnu::visibility("hidden")]] Runtime;  // its threads, mailboxes and pending requests

  Result<void> create_own_mailboxes();
  [[nodiscard]] std::string description() const;

  const ModuleInfo& info_;
  Parameters parameters_;  // protected by mutex_
  TextLog log_;
  std::unique_ptr<Runtime> runtime_;
  std::vector<OwnMailbox*> own_mailboxes_;
  struct PartnerNames {
    std::uint32_t class_id = 0;
    std::string system;  // the names of its parameters
    std::string instance;
  };
  std::vector<PartnerNames> partners_;  // complete before the tasks start
};

// A mailbox of a component, as a member of its class: created after module_init(), with the next
// local id in the order of the members and the priority of the data task, for bodies of at least
// kReasonMax bytes.
//
//   OwnMailbox work_{*this, 1, body_max<PositionData>()};
class OwnMailbox {
 public:
  OwnMailbox(Module& owner, std::uint32_t slots, std::uint32_t body_max);
  OwnMailbox(const OwnMailbox&) = delete;
  OwnMailbox& operator=(const OwnMailbox&) = delete;

  // In module_init(): for a size that depends on parameters.
  void set_body_max(std::uint32_t body_max) { body_max_ = body_max; }

  tims::Mailbox& operator*() const { return *mailbox_; }
  tims::Mailbox* operator->() const { return mailbox_; }

 private:
  friend class Module;

  std::uint32_t slots_;
  std::uint32_t body_max_;
  tims::Mailbox* mailbox_ = nullptr;
};

template <Struct Body>
void Module::reply(const tims::Header& request, std::int8_t type, const Body& body) {
  std::vector<std::byte> bytes(encoded_size(body));
  const bool good = encode(body, bytes).ok();
  if (!good) bytes.clear();
  reply(request, good ? type : tims::type::kError, std::span<const std::byte>(bytes));
}

}  // namespace rack

#pragma GCC visibility pop
