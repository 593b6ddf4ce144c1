#include "tools/cli/failure.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>

#include <CLI/CLI.hpp>
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
      return "start one with `tims-router`, or name another with -H; `timsctl doctor` looks closer";
    case Errc::kTimeout:
      return "a longer --timeout, or `timsctl doctor`";
    case Errc::kNoMailbox:
      return "`timsctl mbx list` shows all";
    case Errc::kAddressInUse:
      return "`timsctl mbx show ADDR` names the owner";
    case Errc::kFull:
      return "the receiver does not keep up; `timsctl mbx show ADDR` shows what waits";
    case Errc::kTooBig:
      return "`timsctl mbx show ADDR` shows the largest message it takes";
    case Errc::kVersion:
    case Errc::kBadLayout:
      return "install timsctl and tims-router of the same version";
    default:
      return {};
  }
}

constexpr CatalogueEntry kEntries[] = {
    // Why a message was not delivered (timsctl stats).
    {"no_route", "reason", "nobody has registered the destination",
     "is the component running? `timsctl route show`, `timsctl route watch`"},
    {"mailbox_full", "reason", "the receiver's mailbox held only more important messages",
     "the receiver does not keep up: `timsctl mbx list --sort refused`"},
    {"mailbox_replaced", "reason", "a newer message took the place of one that was waiting",
     "normal for a reader that wants the newest only; else `timsctl mbx list --sort replaced`"},
    {"too_big", "reason", "the message was larger than a slot of the receiver's mailbox",
     "`timsctl mbx list --sort too_big` names it; open it with a larger body_max"},
    {"queue_full", "reason", "a TCP client, WebSocket client or link was too slow",
     "`timsctl router clients --sort queue`, `timsctl link show -o wide`; a faster network or less "
     "data for it, or tcp.queue"},
    {"queue_replaced", "reason",
     "a TCP client, WebSocket client or link was too slow, and a newer message took the place",
     "`timsctl router clients --sort queue`, `timsctl link show -o wide`; a faster network or less "
     "data for it, or tcp.queue"},
    {"client_gone", "reason", "the receiver went away before it had read the message",
     "`timsctl status` shows who left, and why"},
    {"owner_gone", "reason", "the receiver had closed its mailbox, or had died",
     "`timsctl route watch` shows who comes and goes"},
    {"forged_source", "reason", "the sender does not own the address it sent from",
     "a program sends with somebody else's address: correct it; over TCP it is only counted"},
    {"bad_length", "reason", "a header said less than 16 bytes or more than message.max",
     "a program that is no TiMS client, or message.max is too small"},
    {"incomplete", "reason",
     "the sender went away in the middle of a message, or a link did not go on with it for 2 to 30 "
     "s",
     "`timsctl status` shows who left, `timsctl link show` what a link loses"},
    {"malformed_command", "reason", "a command to the router was too short",
     "a client program with a mistake"},
    {"unknown_command", "reason", "a command to the router that it does not know",
     "a client of another version?"},

    {"hop_limit", "reason", "the message had passed 16 links: routers send it round in a loop",
     "`timsctl status` names the routers; `timsctl route show` lists static routes"},
    {"would_return", "reason", "the only way on was the link the message came from",
     "`timsctl explain SRC DST`"},
    {"link_reset", "reason",
     "the message was on its way over a link whose other router was started anew",
     "commands were answered NOT_AVAILABLE: send them again"},
    {"expired", "reason", "the message could not be sent within the link's lifetime for messages",
     "`timsctl link show -o wide`; a faster link, less data, or a longer lifetime of the [[link]]"},

    // Errors of calls and questions.
    {"no_such_router", "error", "no router of the fleet has this name or address",
     "`timsctl router list`"},
    {"not_done", "error", "the router did not do what it was asked to", ""},
    {"no_router", "error", "no router answers at the socket or address",
     "start `tims-router`; -H or $TIMS_ROUTER for another one"},
    {"timeout", "error", "no answer within --timeout", "`timsctl ping ADDR`; a longer --timeout"},
    {"address_in_use", "error", "somebody else owns the address",
     "`timsctl mbx show ADDR` names the owner; give one of the two another instance"},
    {"no_such_mailbox", "error", "nobody has registered the address", "`timsctl mbx list`"},
    {"denied", "error", "the system does not let you use the router's socket",
     "join the socket's group, or use sudo"},
    {"no_device", "error", "the device cannot be opened, or went away", "`timsctl device list`"},
    {"bad_recording", "error", "the file is no recording, or broken from some line on",
     "`timsctl device play FILE` tells where"},
    {"version", "error", "the two sides speak different versions of the protocol",
     "install the same version on both"},
    {"component_off", "error", "the component answers ERROR: it is not switched on",
     "`timsctl msg pub ADDR on`"},
    {"bad_argument", "error", "the router understood the question but not an argument of it",
     "install timsctl and tims-router of the same version"},
    {"unknown_question", "error", "the router does not know this question",
     "install timsctl and tims-router of the same version"},

    // Findings of the doctor.
    {"router.reachable", "doctor", "whether a router answers", "start `tims-router`"},
    {"router.version", "doctor", "whether timsctl and the router are of one version",
     "install the same version of both"},
    {"router.turn", "doctor", "the longest time the router took for one turn of its loop",
     "the machine is overloaded, or the router was stopped; give it a priority (Nice= or RT)"},
    {"socket.permissions", "doctor", "who may connect to the local socket",
     "socket's folder: owner, group and mode"},
    {"port.tcp", "doctor", "where the router listens for TCP clients, or who has its port",
     "stop the other program, or another tcp.listen"},
    {"port.http", "doctor", "where the router listens for HTTP, or who has its port",
     "stop the other program, or another http.listen"},
    {"limits.files", "doctor", "how many files the router may open, and has opened",
     "LimitNOFILE= in the unit, or `ulimit -n` before the start"},
    {"memory.shared", "doctor", "whether shared memory can be made, and how much is left",
     "free memory, or a larger /dev/shm"},
    {"clock.synchronised", "doctor", "whether this host's clock follows a reference",
     "chrony or systemd-timesyncd: times of several hosts are compared"},
    {"clock.difference", "doctor", "the router's clock against this one",
     "synchronise the clocks of both hosts"},
    {"sockets.buffers", "doctor", "how much the system lets a socket buffer",
     "sysctl net.core.rmem_max and wmem_max, 4194304 or more"},
    {"sockets.udp", "doctor", "the buffers of the socket under all links",
     "sysctl -w net.core.rmem_max=8388608 net.core.wmem_max=8388608, then restart the router"},
    {"links", "doctor", "links to other routers", "`timsctl link show`"},
    {"links.down", "doctor", "a link to another router that is not up",
     "does its router run, and does its UDP port pass the firewalls? `timsctl link show`"},
    {"links.refused", "doctor", "a link that the other router does not accept",
     "correct what it says in the configuration of one of the two, and reload it"},
    {"links.mtu", "doctor", "a link that carries small datagrams only",
     "a tunnel, or a filter that drops large packets? `ping -M do -s 1444 HOST` shows where"},
    {"links.clock", "doctor",
     "the clock of the router at the other end of a link against this one's",
     "synchronise both clocks (chrony): `timsctl clock`"},
    {"links.loss", "doctor", "datagrams that are lost on a link",
     "the radio, the cable, or too much traffic beside: `timsctl link show -o wide -w`"},
    {"routers.duplicate", "doctor", "two living routers with the same system and id",
     "give one of them another [router] id; `timsctl route watch` names both"},
    {"addresses.duplicate", "doctor", "two routers that have a mailbox with the same address",
     "`timsctl route watch` names both; give one component another instance"},
    {"routes.loop", "doctor", "messages or registrations that went round in a loop",
     "static routes against each other? `timsctl route show` at each router, `timsctl route del`"},
    {"mailboxes.dead", "doctor", "mailboxes whose owner is no longer running",
     "restart the router; if it comes again, report it"},
    {"mailboxes.duplicate", "doctor", "programs that wanted an address somebody else has",
     "`timsctl route watch` names both; give one of them another instance"},
    {"mailboxes.full", "doctor", "mailboxes without a free slot: the owner does not take",
     "is the owner stuck? `timsctl mbx show ADDR`"},
    {"drops", "doctor", "messages that were not delivered", "`timsctl stats --by reason`"},

    // Exit status.
    {"0", "exit status", "done, the answer is yes; a verb without end was ended by Ctrl-C", ""},
    {"1", "exit status", "the answer is no, a check failed, a component said ERROR", ""},
    {"2", "exit status", "the command line is wrong", "--help of the command"},
    {"3", "exit status", "no router, or it cannot be reached", "`timsctl doctor`"},
    {"4", "exit status", "no such address, file or code", "`timsctl mbx list`"},
    {"5", "exit status", "the system or the router refused, or you did not confirm", ""},
    {"6", "exit status", "no answer in time, or only a part of it", "a longer --timeout"},
    {"7", "exit status", "the two sides do not speak the same protocol",
     "the same version on both"},
    {"130", "exit status", "Ctrl-C before it was done", ""},
};

}  // namespace

Failure usage_error(std::string message, std::string hint) {
  return {Exit::kUsage, "usage", std::move(message), std::move(hint)};
}

Failure no_such_mailbox(const std::string& address, std::string hint) {
  return {Exit::kNoSuch, "no_such_mailbox", address + ": nobody has registered this address",
          std::move(hint)};
}

std::string nearest_hint(std::string_view name, std::span<const std::string_view> known,
                         std::string otherwise) {
  if (const auto near = base::nearest(name, known)) return fmt::format("did you mean {}?", *near);
  if (!otherwise.empty() || known.empty()) return otherwise;
  return fmt::format("there are {}", fmt::join(known, ", "));
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

int run_program(int argc, char** argv, CLI::App& app, const std::function<Exit()>& run) {
  try {
    app.parse(argc, argv);
    return static_cast<int>(run());
  } catch (const CLI::ParseError& error) {  // also --help and --version
    return static_cast<int>(app.exit(error) == 0 ? Exit::kDone : Exit::kUsage);
  } catch (const Failure& failure) {
    std::fputs(failure_text(failure).c_str(), stderr);
    return static_cast<int>(failure.exit);
  } catch (const Interrupted&) {
    return static_cast<int>(Exit::kInterrupted);
  }
}

std::span<const CatalogueEntry> catalogue() { return kEntries; }

const CatalogueEntry* find_in_catalogue(std::string_view code) {
  const auto* const entry = std::ranges::find(kEntries, code, &CatalogueEntry::code);
  return entry == std::end(kEntries) ? nullptr : entry;
}

}  // namespace timsctl
