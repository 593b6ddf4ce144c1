// Between the router and the policy: makes the policy's questions out of messages, and applies its
// verdicts to them.
#pragma once

#include <optional>
#include <string>

#include "router/core/registrations.h"
#include "router/core/types.h"
#include "router/policy/enforcer.h"
#include "tims/address.h"
#include "tims/time.h"

namespace tims::core {

// GET_CONT_DATA and STOP_CONT_DATA name the mailbox that data are sent to: in their body, in its
// byte order, after the period.
constexpr bool is_about_streams(const Header& header) {
  return header.type == type::kGetContData || header.type == type::kStopContData;
}
// Empty: another message, or one that is too short.
std::optional<Address> data_mailbox(const Message& message);

class PolicyGate {
 public:
  // From now on, clients that connect are judged by it. Precondition: no client is connected.
  void use(policy::Enforcer& enforcer) { enforcer_ = &enforcer; }
  // Null: everything may be sent.
  [[nodiscard]] const policy::Enforcer* enforcer() const { return enforcer_; }
  [[nodiscard]] policy::Enforcer* enforcer() { return enforcer_; }

  void enter(Time now, Client& client);
  void leave(Time now, Client& client);

  // Whether the message needs no verdict: its sender may send everything, or has sent the same
  // lately.
  [[nodiscard]] bool passes(const Client& sender, const Message& message) {
    return !sender.is_judged() ||
           enforcer_->passes_again(*sender.profile, sender.recent, message.header,
                                   static_cast<std::uint32_t>(message.bytes.size()));
  }
  // Precondition: the sender is judged. Lowers the message's priority, and removes its flag TRACE,
  // if the policy says so. `right`: what a question to a router needs.
  policy::Verdict judge(Time now, Client& sender, Message& message, policy::Right right);
  // A message was delivered: its receiver may answer it.
  void delivered(Time now, const Client& receiver, const Message& message) {
    if (message.header.type > 0 && receiver.is_judged()) asked(now, message);
  }

  // "rule \"no driving\" at router.toml:12 for user:guest"
  [[nodiscard]] std::string text_of(policy::RuleNumber number, const Client& sender) const;

 private:
  void asked(Time now, const Message& command);

  policy::Enforcer* enforcer_ = nullptr;
};

}  // namespace tims::core
