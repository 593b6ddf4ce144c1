// What every component is derived from (specification, section 5).
//
//   class Sweeper : public rack::Module {
//    public:
//     Sweeper() : Module(kInfo) {}
//    private:
//     Result<void> module_on() override;    // what it needs while it is on
//     Result<void> module_loop() override;  // again and again while it is on
//     void module_off() override;           // also after one of the two has failed
//   };
//   int main(int argc, char** argv) {
//     Sweeper sweeper;
//     return sweeper.run(argc, argv);
//   }
//
// Two threads: the *command task* takes commands from the command mailbox and answers them; the
// *data task* turns the component on and off and calls module_loop(). What both use is protected by
// whoever derives; the runtime's own state is.
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

// A component's program, in a few words.
struct ModuleInfo {
  std::string_view program;  // "ChassisSim"; the first of its parameters
  std::string_view purpose;  // for --help
  std::uint32_t class_id = 0;
  std::span<const ParameterInfo> parameters{};  // its own, and common ones with another default
  std::uint32_t command_slots = 16;
  std::uint32_t command_body_max = 8192;  // takes 47 parameters at once
  const ClassInfo* own_class = nullptr;   // of a class that is none of RACK's: its messages
};

// Of run(): what a program ends with.
enum class ExitCode : int { kGood = 0, kFailed = 1, kUsage = 2 };

class Module {
 public:
  explicit Module(const ModuleInfo& info);  // which must outlive it
  Module(const Module&) = delete;
  Module& operator=(const Module&) = delete;
  virtual ~Module();

  // All of a program's life: arguments, router, tasks, until SIGTERM, SIGINT, SIGHUP or
  // stop(). A service manager (sd_notify(3)) is told when it is ready, and its status: on, off,
  // error.
  int run(int argc, char** argv);
  int run(std::span<const char* const> arguments);
  void stop();  // from any thread

  [[nodiscard]] tims::Address address() const;
  [[nodiscard]] const Parameters& parameters() const { return parameters_; }

 protected:
  // --- what a component fills in

  // Once, before the tasks start: mailboxes and proxies. An error ends the program.
  virtual Result<void> module_init() { return {}; }
  virtual void module_cleanup() {}
  virtual Result<void> module_on() { return {}; }
  virtual void module_off() {}
  // May wait at most as long as people are ready to wait for OFF. An error: off, and on again
  // later.
  virtual Result<void> module_loop() = 0;
  // A command that is not common to all. An error is answered by ERROR. Called by the command task.
  virtual Result<void> module_command(const tims::MessageView& message);
  // Work without a router, when a parameter asks for it instead of all that: what the program says
  // and ends with. Nothing: it does not.
  struct Report {
    ExitCode code = ExitCode::kGood;
    std::string text{};
  };
  virtual std::optional<Result<Report>> run_alone() { return {}; }

  // --- what a component uses

  TextLog& log() { return log_; }
  // Any task: a copy of what the parameter is now.
  [[nodiscard]] std::int32_t integer(std::string_view name) const;
  [[nodiscard]] float real(std::string_view name) const;
  [[nodiscard]] std::string text(std::string_view name) const;
  // Of what a component has found out itself; must be a number that its parameter allows.
  void set_parameter(std::string_view name, std::int32_t value);
  // A text longer than parameters are (79 bytes) becomes an empty one.
  void set_parameter(std::string_view name, std::string_view value);

  // With what this parameter shall be when the program is started again after a crash, because it
  // goes on where it was: nobody has set it.
  void tell_state(std::string_view name, const std::string& value) const;
  // With the next local id, and the priority of the data task; takes bodies of at least kReasonMax
  // bytes. In module_init().
  Result<tims::Mailbox*> create_mailbox(std::uint32_t slots, std::uint32_t body_max);
  Result<void> create_mailbox(tims::Mailbox*& mailbox, std::uint32_t slots, std::uint32_t body_max);
  // An Input (rack/input.h) with a mailbox for its stream.
  template <typename InputType>
  Result<void> create_input(std::optional<InputType>& input, tims::Mailbox& work,
                            std::uint32_t slots, std::uint32_t body_max) {
    const auto stream = create_mailbox(slots, body_max);
    if (!stream) return stream.error();
    input.emplace(work, **stream);
    return {};
  }
  // At an address that is not one of its own: its text says who has it (kAddressInUse). Any task.
  Result<tims::Mailbox> open_mailbox(const tims::MailboxOptions& options);
  [[nodiscard]] tims::Mailbox& command_mailbox();
  // Of a component of this fleet, local id 0.
  [[nodiscard]] tims::Address address_of(std::uint32_t class_id, std::int32_t system,
                                         std::int32_t instance) const;
  // Of the one that parameters name: "chassis" stands for chassisSys and chassisInst.
  [[nodiscard]] tims::Address address_of(std::uint32_t class_id, std::string_view name) const;
  // Makes a proxy of that one and turns it on; none where its instance is below 0.
  template <typename ProxyType>
  Result<void> turn_on_if_named(std::optional<ProxyType>& proxy, tims::Mailbox& work,
                                std::uint32_t class_id, std::string_view name) {
    proxy.reset();
    if (integer(std::string(name) + "Inst") < 0) return {};
    return proxy.emplace(work, address_of(class_id, name)).on();
  }
  [[nodiscard]] tims::AddressWidths address_widths() const;
  // The component that owns a mailbox: the address without its local id.
  [[nodiscard]] tims::Address component_of(tims::Address mailbox) const;

  // False: not delivered. Who has gone meanwhile needs no answer.
  bool reply(const tims::Header& request, std::int8_t type, std::span<const std::byte> body = {});
  template <Struct Body>
  void reply(const tims::Header& request, std::int8_t type, const Body& body);
  // What module_command() returns of a command whose answer is OK once it is done.
  Result<void> answered(const tims::MessageView& command, Result<void> done) {
    if (done) reply(command.header, tims::type::kOk);
    return done;
  }
  // Why it does not do what it is asked, for the log.
  static tims::Error refused(std::string text) {
    return {tims::Errc::kInvalidArgument, std::move(text)};
  }

  [[nodiscard]] bool is_on() const;
  [[nodiscard]] bool is_stopping() const;
  // Nobody has turned it off, and it is not stopping: for module_on() that waits for something.
  [[nodiscard]] bool is_wanted() const;
  // The data task sleeps until the next multiple of `period` since it was turned on; late ones are
  // left out, not made up for. Returns that time.
  tims::Time sleep_until_next(tims::Duration period);

  // --- DataModule only: between a component and the runtime
  virtual void turned_off() {}   // before module_off()
  mutable PriorityMutex mutex_;  // of the runtime's state

 private:
  class [[gnu::visibility("hidden")]] Runtime;  // its threads and mailboxes, and whom it answers

  const ModuleInfo& info_;
  Parameters parameters_;  // under mutex_
  TextLog log_;
  std::unique_ptr<Runtime> runtime_;
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
