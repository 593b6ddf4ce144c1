#include "tools/cli/failure.h"

#include <algorithm>
#include <cerrno>

#include <fmt/format.h>

#include "base/text.h"

namespace timsctl {

using tims::Errc;

namespace {

Exit exit_of(Errc code) {
  switch (code) {
    case Errc::kNoRouter:
    case Errc::kClosed:
      return Exit::kNoRouter;
    case Errc::kTimeout:
      return Exit::kTimeout;
    case Errc::kNoMailbox:
      return Exit::kNoSuch;
    case Errc::kRefused:
    case Errc::kAddressInUse:
      return Exit::kDenied;
    case Errc::kVersion:
    case Errc::kBadLayout:
      return Exit::kVersion;
    case Errc::kInvalidArgument:
      return Exit::kUsage;
    default:
      return Exit::kNo;
  }
}

std::string hint_of(Errc code) {
  switch (code) {
    case Errc::kNoRouter:
    case Errc::kClosed:
      return "start one with `tims-router`, or name another with -H; `timsctl doctor` finds the "
             "cause";
    case Errc::kTimeout:
      return "use a longer --timeout, or run `timsctl doctor`";
    case Errc::kNoMailbox:
      return "`timsctl mbx list` shows all";
    case Errc::kAddressInUse:
      return "`timsctl mbx show ADDR` names the owner";
    case Errc::kFull:
      return "the receiver is too slow; `timsctl mbx show ADDR` shows its waiting messages";
    case Errc::kTooBig:
      return "`timsctl mbx show ADDR` shows its largest message size";
    case Errc::kVersion:
    case Errc::kBadLayout:
      return "install timsctl and tims-router of the same version";
    default:
      return {};
  }
}

constexpr CatalogueEntry kEntries[] = {
    // Reasons why a message was not delivered (timsctl stats).
    {"no_route", "reason", "the destination is not registered",
     "is the component running? `timsctl route show`, `timsctl route watch`"},
    {"mailbox_full", "reason", "the receiver's mailbox held only more important messages",
     "the receiver is too slow: `timsctl mbx list --sort refused`"},
    {"mailbox_replaced", "reason", "a newer message replaced a waiting one",
     "normal for a reader that needs only the newest; else `timsctl mbx list --sort replaced`"},
    {"too_big", "reason", "the message was larger than a slot of the receiver's mailbox",
     "`timsctl mbx list --sort too_big` names the mailbox; open it with a larger body_max"},
    {"queue_full", "reason", "a TCP client, WebSocket client or link was too slow",
     "find it with `timsctl router clients --sort queue` or `timsctl link show -o wide`; use a "
     "faster network, send less data, or increase tcp.queue"},
    {"queue_replaced", "reason",
     "a TCP client, WebSocket client or link was too slow; a newer message replaced a queued one",
     "find it with `timsctl router clients --sort queue` or `timsctl link show -o wide`; use a "
     "faster network, send less data, or increase tcp.queue"},
    {"client_gone", "reason", "the receiver disconnected before it had read the message",
     "`timsctl status` shows which client disconnected, and why"},
    {"owner_gone", "reason", "the receiver had closed its mailbox, or had crashed",
     "`timsctl route watch` shows registrations and withdrawals"},
    {"forged_source", "reason", "the sender does not own the address it sent from",
     "a program sends with the address of another one: correct it; over TCP it is only counted"},
    {"bad_length", "reason",
     "the length in a header is less than 16 bytes or more than message.max",
     "the sender is not a TiMS client, or message.max is too small"},
    {"incomplete", "reason",
     "the sender disconnected within a message, or a link did not continue it for 2 to 30 s",
     "`timsctl status` shows disconnected clients, `timsctl link show` the loss of links"},
    {"malformed_command", "reason", "a command to the router was too short",
     "the client program has an error"},
    {"unknown_command", "reason", "the router does not know the command",
     "does the client have another version?"},

    {"hop_limit", "reason", "the message had passed 16 links: there is a routing loop",
     "`timsctl status` names the routers; `timsctl route show` lists static routes"},
    {"would_return", "reason", "the only route was back over the link on which the message arrived",
     "`timsctl explain SRC DST`"},
    {"link_reset", "reason", "the message was in transit on a link when the other router restarted",
     "commands were answered NOT_AVAILABLE: send them again"},
    {"expired", "reason", "the message could not be sent within the link's lifetime for messages",
     "`timsctl link show -o wide`; use a faster link, less data, or a longer lifetime in [[link]]"},
    {"no_lease", "reason", "a driving command for a robot that somebody else drives",
     "`timsctl route watch` shows who drives it; the console's page Drive takes it over"},
    {"no_right", "reason", "the login or certificate of the sender has not the right for it",
     "log in with a higher right (`timsctl web`), or `timsctl key sign --rights` another one"},

    // Errors of calls and requests.
    {"none_kept", "error", "the router keeps no newest value of this component",
     "it keeps what passes it, of the classes in newest.streams"},
    {"no_such_router", "error", "no router of the fleet has this name or address",
     "`timsctl router list`"},
    {"not_done", "error", "the router did not execute the request", ""},
    {"no_router", "error", "no router answers at the socket or address",
     "start `tims-router`, or name another one with -H or $TIMS_ROUTER"},
    {"timeout", "error", "no answer within --timeout",
     "`timsctl ping ADDR`, or a longer --timeout"},
    {"address_in_use", "error", "another client owns the address",
     "`timsctl mbx show ADDR` names the owner; give one of the two another instance"},
    {"no_such_mailbox", "error", "the address is not registered", "`timsctl mbx list`"},
    {"denied_by_rule", "error", "a rule of the policy of a router denies the message",
     "`timsctl acl show` lists its rules, `timsctl acl test` tries them"},
    {"denied", "error", "the system denies access to the socket of the router",
     "join the group of the socket, or use sudo"},
    {"no_device", "error", "the device cannot be opened, or was disconnected",
     "`timsctl device list`"},
    {"bad_recording", "error", "the file is not a recording, or it is damaged",
     "`timsctl device play FILE` states its format and what is unreadable in it"},
    {"version", "error", "the two sides use different versions of the protocol",
     "install the same version on both"},
    {"component_off", "error", "the component answers ERROR: it is not switched on",
     "`timsctl msg pub ADDR on`"},
    {"bad_argument", "error", "the router knows the request but not one of its arguments",
     "install timsctl and tims-router of the same version"},
    {"unknown_question", "error", "the router does not know this request",
     "install timsctl and tims-router of the same version"},

    // Findings of timsctl doctor.
    {"router.reachable", "doctor", "whether a router answers", "start `tims-router`"},
    {"router.version", "doctor", "whether timsctl and the router have the same version",
     "install the same version of both"},
    {"router.turn", "doctor", "the longest time the router took for one turn of its loop",
     "the machine is overloaded, or the router was stopped; raise its priority (Nice= or RT)"},
    {"socket.permissions", "doctor", "which users may connect to the local socket",
     "check owner, group and mode of the folder of the socket"},
    {"port.tcp", "doctor",
     "where the router listens for TCP clients, or which program uses its port",
     "stop the other program, or configure another tcp.listen"},
    {"port.http", "doctor", "where the router listens for HTTP, or which program uses its port",
     "stop the other program, or configure another http.listen"},
    {"limits.files", "doctor", "the number of files that the router may open, and has opened",
     "set LimitNOFILE= in the unit, or `ulimit -n` before the start"},
    {"memory.shared", "doctor", "whether shared memory can be created, and how much is free",
     "free memory, or enlarge /dev/shm"},
    {"clock.synchronised", "doctor", "whether this host's clock follows a reference",
     "run chrony or systemd-timesyncd: times of several hosts are compared"},
    {"clock.difference", "doctor",
     "the offset between the clock of the router and that of this host",
     "synchronise the clocks of both hosts"},
    {"sockets.buffers", "doctor", "the largest socket buffer that the system permits",
     "set sysctl net.core.rmem_max and wmem_max to 4194304 or more"},
    {"sockets.udp", "doctor", "the buffers of the UDP socket of all links",
     "sysctl -w net.core.rmem_max=8388608 net.core.wmem_max=8388608, then restart the router"},
    {"links", "doctor", "links to other routers", "`timsctl link show`"},
    {"links.down", "doctor", "a link to another router that is not up",
     "is its router running, and do firewalls pass its UDP port? `timsctl link show`"},
    {"links.refused", "doctor", "a link that the other router does not accept",
     "correct the named value in the configuration of one of the routers, and reload it"},
    {"links.mtu", "doctor", "a link that carries only small datagrams",
     "a tunnel, or a filter that drops large packets? `ping -M do -s 1444 HOST` shows where"},
    {"links.clock", "doctor", "the clock offset of the router at the other end of a link",
     "synchronise both clocks (chrony): `timsctl clock`"},
    {"links.loss", "doctor", "datagrams that are lost on a link",
     "check radio, cable, and other traffic: `timsctl link show -o wide -w`"},
    {"links.faults", "doctor", "faults that somebody has injected into what is sent over a link",
     "`timsctl sim fault --link all heal` ends them; without sim.faults nobody can inject any"},
    {"routers.duplicate", "doctor", "two running routers with the same system and id",
     "give one of them another [router] id; `timsctl route watch` names both. A cloned card has "
     "the "
     "keys of its original: `timsctl token new` on the base, `timsctl join` on the clone"},
    {"keys", "doctor", "the keys of this router and what it is in the fleet",
     "`timsctl key init` on the base, `timsctl token new` there, `timsctl join` here, then "
     "security.keys"},
    {"keys.folder", "doctor", "files of keys that cannot be used",
     "run the command that the text names; the router reads the files again by itself"},
    {"keys.revoked", "doctor", "a router whose certificate is revoked",
     "if it is yours again: `timsctl token new` on the base, `timsctl join` here"},
    {"keys.end", "doctor", "a certificate that ends, has ended, or is not valid yet",
     "`timsctl key renew`; compare the clocks with `timsctl clock`"},
    {"security.cautions", "doctor", "what the configuration allows although it is dangerous",
     "do without it, or keep the hosts of the network that can reach this one under your control"},
    {"addresses.duplicate", "doctor", "two routers that have a mailbox with the same address",
     "`timsctl route watch` names both; give one component another instance"},
    {"routes.loop", "doctor", "messages or registrations in a routing loop",
     "are there contradictory static routes? `timsctl route show` at each router, `timsctl route "
     "del`"},
    {"mailboxes.dead", "doctor", "mailboxes whose owner is no longer running",
     "restart the router; if the problem returns, report it"},
    {"mailboxes.duplicate", "doctor", "programs that requested an address of another program",
     "`timsctl route watch` names both; give one of them another instance"},
    {"mailboxes.full", "doctor", "mailboxes without a free slot: the owner does not read",
     "is the owner stuck? `timsctl mbx show ADDR`"},
    {"components.error", "doctor", "components whose state is error", "`timsctl log follow`"},
    {"drops", "doctor", "messages that were not delivered", "`timsctl stats --by reason`"},

    // Exit status.
    {"0", "exit status", "done, the answer is yes; a continuous verb was stopped by Ctrl-C", ""},
    {"1", "exit status", "the answer is no, a check failed, a component answered ERROR", ""},
    {"2", "exit status", "the command line is wrong", "see --help of the command"},
    {"3", "exit status", "there is no router, or it cannot be reached", "`timsctl doctor`"},
    {"4", "exit status", "no such address, file or code", "`timsctl mbx list`"},
    {"5", "exit status", "the system or the router refused, or you did not confirm", ""},
    {"6", "exit status", "no answer in time, or only a part of it", "use a longer --timeout"},
    {"7", "exit status", "the two sides do not use the same protocol version",
     "install the same version on both"},
    {"130", "exit status", "Ctrl-C before it was done", ""},
};

}  // namespace

Failure usage_error(std::string message, std::string hint) {
  return {Exit::kUsage, "usage", std::move(message), std::move(hint)};
}

Failure no_such_mailbox(const std::string& address, std::string hint) {
  return {Exit::kNoSuch, "no_such_mailbox", address + ": this address is not registered",
          std::move(hint)};
}

std::string nearest_hint(std::string_view name, std::span<const std::string_view> known,
                         std::string otherwise) {
  if (const auto near = base::nearest(name, known)) return fmt::format("did you mean {}?", *near);
  if (!otherwise.empty() || known.empty()) return otherwise;
  return fmt::format("known: {}", fmt::join(known, ", "));
}

void fail_if_any(std::span<const base::Problem> problems, const std::string& code,
                 const std::string& hint) {
  std::string text;
  for (const base::Problem& problem : problems)
    text.append(text.empty() ? "" : "\n").append(problem.to_string());
  if (!text.empty()) throw Failure(Exit::kNo, code, text, hint);
}

Failure failure_of(const tims::Error& error, const std::string& where) {
  std::string message = error.message();
  if (!where.empty() && message.find(where) == std::string::npos) message = where + ": " + message;
  return {exit_of(error.code()), std::string(tims::name(error.code())), std::move(message),
          hint_of(error.code())};
}

std::string failure_text(const Failure& failure) {
  std::string text = fmt::format("{}: {}\n", program_invocation_short_name,
                                 base::printable_lines(failure.message));
  if (!failure.hint.empty()) text += fmt::format("  -> {}\n", failure.hint);
  return text;
}

std::span<const CatalogueEntry> catalogue() { return kEntries; }

const CatalogueEntry* find_in_catalogue(std::string_view code) {
  const auto* const entry = std::ranges::find(kEntries, code, &CatalogueEntry::code);
  return entry == std::end(kEntries) ? nullptr : entry;
}

}  // namespace timsctl
