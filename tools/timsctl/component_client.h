// The client side of a component: commands and answers, parameters, data subscriptions.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rack/codec/codec.h"
#include "rack/proxies/generic.h"
#include "tools/cli/arguments.h"
#include "tools/cli/connection.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/cli/output.h"
#include "tools/timsctl/message_path.h"

namespace timsctl {

// Sends one request at a time, on its own connection.
class ComponentClient {
 public:
  explicit ComponentClient(Context& context, const MailboxRequest& request = {})
      : context_(context), connection_(context.connect(request)) {}

  [[nodiscard]] tims::AddressWidths widths() const { return connection_->widths(); }
  [[nodiscard]] tims::Address address(std::string_view text) const {
    return need_address(text, widths());
  }

  // Throws Failure: the address is not registered, or there is no answer in time. ERROR is an
  // answer.
  Message ask(tims::Address component, std::int8_t type, std::span<const std::byte> body = {},
              std::optional<tims::Duration> timeout = {});

  template <rack::Struct Body>
  Message ask(tims::Address component, std::int8_t type, const Body& body,
              std::optional<tims::Duration> timeout = {}) {
    std::vector<std::byte> bytes(rack::encoded_size(body));
    (void)value_or_fail(rack::encode(body, bytes), name_of(component));
    return ask(component, type, std::span<const std::byte>(bytes), timeout);
  }

  // Supported only by our runtime. Programs of the original RACK answer ERROR, or not at all.
  template <typename Data>
  std::optional<Data> ask_ours(tims::Address component, std::int8_t question,
                               std::int8_t expected) {
    try {
      const Message answer = ask(component, question);
      if (answer.header.type != expected) return std::nullopt;
      return value_or_fail(rack::decode<Data>(answer.view()), name_of(component));
    } catch (const Failure& failure) {
      if (failure.exit == Exit::kTimeout) return std::nullopt;
      throw;
    }
  }

  // The link that explains why a component does not answer, if there is one.
  std::optional<BrokenLink> why_absent(tims::Address component);

  // Empty if it has no data, for example because it is off.
  std::optional<Message> newest_data(tims::Address component);

  // What the router of this connection has kept of it, and how many seconds ago that passed the
  // router; empty: nothing. Asks no component.
  std::optional<Message> kept_data(tims::Address component, std::optional<double>& age_s);

  rack::ParameterList parameters(tims::Address component);
  // When new values take effect; unknown for components of the original RACK.
  std::optional<rack::ParameterEffects> effects(tims::Address component) {
    return ask_ours<rack::ParameterEffects>(component, tims::type::kGetParamEffects,
                                            tims::type::kParamEffects);
  }

  // What it states about itself, as JSON; throws Failure for components of the original RACK.
  std::string description(tims::Address component);

  // The states of several components, in their order; empty without an answer in time.
  std::vector<std::optional<std::int8_t>> states(std::span<const tims::Address> components,
                                                 std::optional<tims::Duration> timeout = {});

  [[nodiscard]] std::string name_of(tims::Address address) const {
    return address.to_string(widths());
  }

 private:
  Context& context_;
  std::unique_ptr<Connection> connection_;
};

// Whether it is the mailbox of a component for commands. Lower class ids belong to routers, the
// GDOS mailbox, and tools.
bool is_component(tims::Address address, const tims::AddressWidths& widths);

// Throws Failure unless the answer is OK. The message is `what` with the reason given by the
// component, if any: components of the original RACK give none.
void need_ok(const Message& answer, const std::string& what, const std::string& hint);

// Checks the condition once, and with --wait repeatedly until it holds or the time is over.
// Rethrows the exception of the last attempt.
bool waited(const Context& context, const std::function<bool()>& attempt);

// "on", "off", "error", or "answer -7" for other values.
std::string state_text(std::int8_t state);

std::optional<rack::TakesEffect> effect_of(const std::optional<rack::ParameterEffects>& effects,
                                           std::string_view name);

json::object parameter_json(const rack::Parameter& parameter,
                            const std::optional<rack::ParameterEffects>& effects);

// --- data subscriptions: after GET_CONT_DATA, a component sends DATA to a mailbox until
// STOP_CONT_DATA. The request is repeated if the component was off, missing or restarted.

class Subscription {
 public:
  enum class State {
    kAsking,     // no answer yet
    kRunning,    // granted
    kOff,        // it answers ERROR: not turned on
    kNoMailbox,  // the address is not registered
    kNoData,     // it is being turned on and has no data yet
  };

  Subscription(tims::Address component, std::uint32_t period_ms)
      : component_(component), period_ms_(period_ms) {}

  [[nodiscard]] tims::Address component() const { return component_; }
  [[nodiscard]] State state() const { return state_; }
  // "on", "off", "no_mailbox", "asking", "no_data"
  [[nodiscard]] std::string_view state_name() const;
  [[nodiscard]] std::optional<std::uint32_t> granted_ms() const { return granted_ms_; }

  // Sends the request if it is due, first or repeated.
  tims::Result<void> on_time(Connection& connection, tims::Time now);
  [[nodiscard]] tims::Time next_time() const { return next_question_; }
  // Handles a message from the component. True: data; false: part of the subscription protocol.
  bool on_message(const Message& message, tims::Time now);
  void stop(Connection& connection) const;
  [[nodiscard]] bool needs_stop() const { return asked_ && state_ != State::kNoMailbox; }

 private:
  void set_state(State state, tims::Time ask_again_at);

  tims::Address component_;
  std::uint32_t period_ms_;
  State state_ = State::kAsking;
  bool asked_ = false;
  std::optional<std::uint32_t> granted_ms_;
  tims::Time next_question_{};
};

// Reports subscriptions from which nothing comes, once each time.
class SilenceNotes {
 public:
  SilenceNotes(std::size_t subscriptions, tims::Time now) : last_(subscriptions, {now}) {}

  void on_data(std::size_t index, tims::Time now) { last_[index] = {now, false, true}; }
  // The reason was reported otherwise.
  void skip(std::size_t index) { last_[index].noted = true; }
  // The notes that are due; `at_end`: also for those from which nothing has come at all.
  std::vector<std::string> take(std::span<const Subscription> subscriptions, tims::Time now,
                                const tims::AddressWidths& widths, bool at_end = false);

 private:
  struct Last {
    tims::Time data{};  // or the beginning
    bool noted = false;
    bool any = false;
  };
  std::vector<Last> last_;
};

// Several subscriptions on one connection. They end together, because no component may continue to
// send to a closed mailbox.
class Subscriptions {
 public:
  Subscriptions(Connection& connection, const std::vector<tims::Address>& components,
                std::uint32_t period_ms);
  ~Subscriptions();  // unsubscribes from every component and waits briefly for the answers
  Subscriptions(const Subscriptions&) = delete;
  Subscriptions& operator=(const Subscriptions&) = delete;

  [[nodiscard]] const std::vector<Subscription>& all() const { return list_; }

  struct Data {
    std::size_t index;  // index of the component
    Message message;
    tims::Time at;
  };
  // The next data, or empty at the deadline. Throws like receive().
  std::optional<Data> next(const Signals& signals, tims::Time deadline);

 private:
  void finish();

  Connection& connection_;
  std::vector<Subscription> list_;
};

}  // namespace timsctl
