#include "router/core/policy_gate.h"

#include <bit>

namespace tims::core {

std::optional<Address> data_mailbox(const Message& message) {
  if (!is_about_streams(message.header)) return std::nullopt;
  const bool starts = message.header.type == type::kGetContData;
  const std::size_t at = starts ? 4 : 0;
  const auto body = message.body();
  if (body.size() < at + 4) return std::nullopt;
  std::uint32_t raw = 0;
  const bool little = message.header.body_order() == std::endian::little;
  for (std::size_t i = 0; i < 4; ++i)
    raw = raw << 8 | std::to_integer<std::uint32_t>(body[at + (little ? 3 - i : i)]);
  return Address(raw);
}

void PolicyGate::enter(Time now, Client& client) {
  if (enforcer_ != nullptr) client.profile = &enforcer_->enter(now, client.info.subject);
}

void PolicyGate::leave(Time now, Client& client) {
  if (client.profile != nullptr) enforcer_->leave(now, *client.profile);
  client.profile = nullptr;
}

policy::Verdict PolicyGate::judge(Time now, Client& sender, Message& message, policy::Right right) {
  Header& header = message.header;
  policy::Query query{.dest = header.dest,
                      .src = header.src,
                      .type = header.type,
                      .is_sample = (header.flags & flag::kStream) != 0 && header.type <= 0,
                      .right = right};
  const policy::Verdict verdict =
      enforcer_->judge(now, *sender.profile, query, header.priority,
                       static_cast<std::uint32_t>(message.bytes.size()));
  header.priority = verdict.priority;
  if (verdict.what != policy::Verdict::What::kPass) return verdict;
  const bool traced = (header.flags & flag::kTrace) != 0;
  // Of others, more than the header is judged.
  if (verdict.lasts && !traced && right == policy::Right::kNone)
    sender.recent.keep(*sender.profile, header, verdict);
  if (traced) {
    query.right = policy::Right::kTrace;
    if (enforcer_->judge(now, *sender.profile, query, 0, 0).what != policy::Verdict::What::kPass)
      header.flags &= static_cast<std::uint8_t>(~flag::kTrace);
  }
  return verdict;
}

void PolicyGate::asked(Time now, const Message& command) {
  enforcer_->asked(now, command.header.src, command.header.dest);
  if (const auto mailbox = data_mailbox(command))
    enforcer_->asked(now, *mailbox, command.header.dest);
}

std::string PolicyGate::text_of(policy::RuleNumber number, const Client& sender) const {
  return enforcer_->policy().rule(number).text.title() + " for " + sender.profile->subject().name;
}

}  // namespace tims::core
