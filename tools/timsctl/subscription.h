// The data of one component, as the original's programs get it: GET_CONT_DATA names a mailbox,
// DATA comes there until STOP_CONT_DATA. Asked for again when the component was off, restarted or
// not there yet.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "tools/cli/connection.h"

namespace timsctl {

class Subscription {
 public:
  enum class State {
    kAsking,     // no answer yet
    kRunning,    // granted
    kOff,        // it says ERROR: not switched on
    kNoMailbox,  // nobody has the address
  };

  Subscription(tims::Address component, std::uint32_t period_ms)
      : component_(component), period_ms_(period_ms) {}

  [[nodiscard]] tims::Address component() const { return component_; }
  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] std::string_view state_name() const;  // "on", "off", "no_mailbox", "asking"
  [[nodiscard]] std::optional<std::uint32_t> granted_ms() const { return granted_ms_; }

  // Sends what is due: the question, and the question again.
  tims::Result<void> on_time(Connection& connection, tims::Time now);
  [[nodiscard]] tims::Time next_time() const { return next_question_; }
  // A message from the component. True: it is data; false: it belonged to the subscription.
  bool on_message(const Message& message, tims::Time now);
  void stop(Connection& connection) const;
  [[nodiscard]] bool needs_stop() const { return asked_ && state_ != State::kNoMailbox; }

 private:
  void heard(State state, tims::Time ask_again_at);

  tims::Address component_;
  std::uint32_t period_ms_;
  State state_ = State::kAsking;
  bool asked_ = false;
  std::optional<std::uint32_t> granted_ms_;
  tims::Time next_question_{};
};

// Several on one connection, ended together: nobody may go on sending to a mailbox that is gone.
class Subscriptions {
 public:
  Subscriptions(Connection& connection, const std::vector<tims::Address>& components,
                std::uint32_t period_ms);
  ~Subscriptions();  // tells every component, and waits a moment for their answers
  Subscriptions(const Subscriptions&) = delete;
  Subscriptions& operator=(const Subscriptions&) = delete;

  [[nodiscard]] const std::vector<Subscription>& all() const { return list_; }

  [[nodiscard]] std::uint64_t missed() const { return connection_.missed(); }

  struct Data {
    std::size_t index;  // of the component
    Message message;
    tims::Time at;
  };
  // The next data; nothing at the deadline. Throws as receive() does.
  std::optional<Data> next(const Signals& signals, tims::Time deadline);

 private:
  void finish();

  Connection& connection_;
  std::vector<Subscription> list_;
};

}  // namespace timsctl
