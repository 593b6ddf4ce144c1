#include "router/core/legacy.h"

#include <algorithm>
#include <bit>
#include <span>

#include "wire/tcp_protocol.h"

namespace tims::core {
namespace {

using LegacyVerb = LegacyCommand::Verb;

constexpr std::size_t kMailboxBodySize = 4;

std::uint32_t read_u32(std::span<const std::byte> bytes, std::endian order) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < kMailboxBodySize; ++i) {
    const std::size_t at = order == std::endian::big ? i : kMailboxBodySize - 1 - i;
    value = value << 8 | std::to_integer<std::uint32_t>(bytes[at]);
  }
  return value;
}

// Bytes after the address are ignored, as in the original.
LegacyCommand with_mailbox(LegacyVerb verb, bool wants_reply, const Message& message) {
  const auto body = message.body();
  if (body.size() < kMailboxBodySize) return {.verb = LegacyVerb::kMalformed};
  return {verb, wants_reply, Address(read_u32(body, message.header.body_order()))};
}

// Unknown options are an extension of a later version, or no options at all: they are ignored.
LegacyCommand registration(bool wants_reply, const Message& message) {
  LegacyCommand command = with_mailbox(LegacyVerb::kRegister, wants_reply, message);
  const auto body = message.body();
  if (body.size() != wire::router_command::kOptionsSize) return command;
  const std::uint32_t options =
      read_u32(body.subspan(kMailboxBodySize), message.header.body_order());
  command.keeps_newest = options == wire::router_command::kKeepNewest;
  return command;
}

}  // namespace

LegacyCommand parse_command(const Message& message) {
  namespace command = wire::router_command;
  switch (message.header.type) {
    case command::kMailboxInit:
      return registration(false, message);
    case command::kMailboxInitWithReply:
      return registration(true, message);
    case command::kMailboxDelete:
      return with_mailbox(LegacyVerb::kDelete, false, message);
    case command::kMailboxDeleteWithReply:
      return with_mailbox(LegacyVerb::kDelete, true, message);
    case command::kMailboxPurge:
      return {.verb = LegacyVerb::kPurge};
    case command::kEnableWatchdog:
      return {.verb = LegacyVerb::kEnableWatchdog};
    case command::kDisableWatchdog:
      return {.verb = LegacyVerb::kDisableWatchdog};
    case command::kLogin:
      return {.verb = LegacyVerb::kLogin};
    case type::kOk:
      return {.verb = LegacyVerb::kAlive};
    case type::kAdminRequest:
      return {.verb = LegacyVerb::kAdmin};
    default:
      return {.verb = LegacyVerb::kUnknown};
  }
}

void Lifesigns::set_interval(Time now, Duration interval) {
  interval_ = interval;
  next_ = std::min(next_, now + interval);
}

void Lifesigns::watch(Time now, Client& client) {
  client.owes_answer = false;
  if (client.watched) return;
  client.watched = true;
  if (watched_++ == 0) next_ = now + interval_;
}

void Lifesigns::unwatch(Client& client) {
  client.owes_answer = false;
  if (!client.watched) return;
  client.watched = false;
  --watched_;
}

Lifesigns::Beat Lifesigns::beat(Time now) {
  if (now < next_beat()) return Beat::kNotYet;
  const bool late = now - next_ > interval_ / 2;
  next_ = late ? now + interval_ : next_ + interval_;
  return late ? Beat::kLate : Beat::kAsk;
}

}  // namespace tims::core
