// Router, the part that carries out the original's commands (legacy.h) and keeps its watchdog.
#include "wire/router_commands.h"

#include <algorithm>

#include "router/core/router.h"
#include "wire/header.h"

namespace tims::core {

Outcome Router::carry_out(Time now, Client& sender, Message& message) {
  using Verb = LegacyCommand::Verb;
  const LegacyCommand command = parse_command(message);
  switch (command.verb) {
    case Verb::kRegister: {
      const Registration result = register_mailbox(now, sender.id, command.mailbox);
      const bool success = result.status == Registration::Status::kOk;
      if (command.wants_reply) answer_command(sender, message.header, success);
      break;
    }
    case Verb::kDelete: {
      const Removal result = remove_mailbox(now, sender.id, command.mailbox);
      // An unknown address is deleted already, says the original.
      const bool success = result != Removal::kNotOwner;
      if (command.wants_reply) answer_command(sender, message.header, success);
      break;
    }
    case Verb::kPurge:
      withdraw_all(now, sender);
      break;
    case Verb::kAlive:
      sender.owes_answer = false;
      break;
    case Verb::kEnableWatchdog:
      lifesigns_.watch(now, sender);
      break;
    case Verb::kDisableWatchdog:
      lifesigns_.unwatch(sender);
      break;
    case Verb::kLogin:
      tell_widths(now, sender, message);
      break;
    case Verb::kAdmin:
      sink_.admin(sender.id, message);
      break;
    case Verb::kMalformed:
      return Outcome::kMalformedCommand;
    case Verb::kUnknown:
      return Outcome::kUnknownCommand;
  }
  return Outcome::kHandled;
}

// The original let anybody delete any mailbox. It had no local clients, and theirs stay out of it:
// other programs send to them without asking the router. So do those of other routers, which would
// not hear of it.
bool Router::may_delete(const Client& by, const Client& owner) const {
  if (by.id == owner.id) return true;
  return settings_.compat_delete && owner.info.port != PortKind::kLocal &&
         owner.info.port != PortKind::kLink;
}

void Router::answer_command(const Client& client, const Header& request, bool success) {
  sink_.reply(receiver_of(client), wire::reply_to(request, success ? type::kOk : type::kError));
}

// To whoever has left room for it: in the place of the question.
void Router::tell_widths(Time now, Client& client, Message& login) {
  namespace command = wire::router_command;
  if (settings_.widths == AddressWidths() || login.body().size() != command::kWidthsSize) return;
  std::ranges::copy(command::encode_widths(settings_.widths),
                    login.bytes.subspan(kHeaderSize).begin());
  login.header = wire::reply_to(login.header, command::kAddressWidths, command::kWidthsSize);
  (void)hand_over(now, receiver_of(client), client, login);
}

void Router::on_progress(ClientId id) {
  if (Client* client = clients_.find(id)) client->owes_answer = false;
}

void Router::on_timeout(Time now) {
  const Lifesigns::Beat beat = lifesigns_.beat(now);
  if (beat == Lifesigns::Beat::kNotYet) return;
  clients_.for_each([&](Client& client) {
    if (!client.watched) return;
    if (client.owes_answer && beat == Lifesigns::Beat::kAsk) {
      give_up(now, client, CloseReason::kWatchdog);
    } else {
      client.owes_answer = true;
      ask_for_lifesign(client);
    }
  });
}

void Router::ask_for_lifesign(const Client& client) {
  count(EventKind::kLifesign);
  sink_.reply(receiver_of(client), {.type = wire::router_command::kLifesign});
}

void Router::give_up(Time now, Client& client, CloseReason reason) {
  const Receiver connection = receiver_of(client);
  disconnect(now, client.id, reason);
  sink_.close(connection, reason);
}

}  // namespace tims::core
