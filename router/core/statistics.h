// Statistics: the outcome of every message (Outcome), events of clients and mailboxes (Event),
// and their counts by port and class.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "router/core/types.h"
#include "tims/address.h"
#include "tims/time.h"

namespace tims::core {

// All possible outcomes of a message. Each message that enters the router gets exactly one when
// it arrives; one that was accepted and is lost later (queue_replaced, mailbox_replaced,
// client_gone, link_reset, expired) is counted once more under that reason.
enum class Outcome : std::uint8_t {
  kDelivered,
  kHandled,
  kNoRoute,
  kMailboxFull,
  kMailboxReplaced,
  kTooBig,
  kQueueFull,
  kQueueReplaced,
  kClientGone,
  kOwnerGone,
  kForgedSource,
  kBadLength,
  kIncomplete,
  kMalformedCommand,
  kUnknownCommand,
  kHopLimit,
  kWouldReturn,
  kLinkReset,
  kExpired,
  kUnread,
  kNoLease,
  kNoRight,
  kDenied,
  kThinned,
};

inline constexpr std::size_t kOutcomeCount = 24;
constexpr std::array kOutcomes{
    Label<Outcome>{Outcome::kDelivered, "delivered",
                   "handed to its receiver's mailbox, connection or queue"},
    Label<Outcome>{Outcome::kHandled, "handled", "addressed to the router itself, and executed"},
    Label<Outcome>{Outcome::kNoRoute, "no_route", "the destination is not registered"},
    Label<Outcome>{Outcome::kMailboxFull, "mailbox_full",
                   "the receiver's mailbox holds only more important messages"},
    Label<Outcome>{Outcome::kMailboxReplaced, "mailbox_replaced",
                   "the receiver did not read it in time, and a newer message replaced it"},
    Label<Outcome>{Outcome::kTooBig, "too_big", "larger than a slot of the receiver's mailbox"},
    Label<Outcome>{
        Outcome::kQueueFull, "queue_full",
        "the receiver reads too slowly, and the messages queued for it are more important"},
    Label<Outcome>{Outcome::kQueueReplaced, "queue_replaced",
                   "the receiver reads too slowly, and a newer message replaced it"},
    Label<Outcome>{Outcome::kClientGone, "client_gone",
                   "the receiver disconnected before reading it"},
    Label<Outcome>{Outcome::kOwnerGone, "owner_gone",
                   "the receiver has closed its mailbox or has exited"},
    Label<Outcome>{Outcome::kForgedSource, "forged_source",
                   "the sender does not own the message's source address, or the link "
                   "it arrived on is not configured for that system"},
    Label<Outcome>{Outcome::kBadLength, "bad_length",
                   "its header states a length below 16 bytes or above message.max"},
    Label<Outcome>{
        Outcome::kIncomplete, "incomplete",
        "the sender disconnected in the middle of it, or the link stopped transferring it"},
    Label<Outcome>{Outcome::kMalformedCommand, "malformed_command",
                   "a command to the router that is too short"},
    Label<Outcome>{Outcome::kUnknownCommand, "unknown_command",
                   "a command to the router that it does not know"},
    Label<Outcome>{Outcome::kHopLimit, "hop_limit",
                   "it passed too many routers: there is a routing loop"},
    Label<Outcome>{Outcome::kWouldReturn, "would_return",
                   "the only route leads back to the link it came from"},
    Label<Outcome>{Outcome::kLinkReset, "link_reset",
                   "it was in transit over a link whose other router has restarted or is gone"},
    Label<Outcome>{Outcome::kExpired, "expired",
                   "it could not be sent over the link within the link's lifetime for messages"},
    Label<Outcome>{Outcome::kUnread, "unread", "a text for users that no program logs or displays"},
    Label<Outcome>{
        Outcome::kNoLease, "no_lease",
        "a driving command for a robot that somebody else drives: only the holder of its "
        "driving lease may drive it"},
    Label<Outcome>{Outcome::kNoRight, "no_right",
                   "its sender's login or certificate has not the right to send it: look, drive or "
                   "configure"},
    Label<Outcome>{Outcome::kDenied, "denied", "no rule of the policy lets its sender send it"},
    Label<Outcome>{Outcome::kThinned, "thinned",
                   "a sample that a rule of the policy leaves out of its stream"},
};
static_assert(complete(kOutcomes, Outcome::kThinned) && kOutcomes.size() == kOutcomeCount);
std::string_view name(Outcome outcome);
std::string_view sentence(Outcome outcome);

// kMailboxReplaced as the result of a port: this message was accepted and an older one was
// dropped for it. An unread text, or a sample that a stream is thinned by, does not count as a
// loss.
constexpr bool taken(Outcome o) {
  return o == Outcome::kDelivered || o == Outcome::kHandled || o == Outcome::kMailboxReplaced ||
         o == Outcome::kUnread || o == Outcome::kThinned;
}

// No route to the destination exists: the sender of a command receives NOT_AVAILABLE.
constexpr bool is_unroutable(Outcome o) {
  return o == Outcome::kNoRoute || o == Outcome::kWouldReturn || o == Outcome::kHopLimit;
}

// Events of clients and mailboxes: counted by kind; the newest are kept for `timsctl route
// watch`.
enum class EventKind : std::uint8_t {
  kClientCame,
  kClientWent,
  kClientRefused,
  kRegistered,
  kWithdrawn,
  kAddressRefused,
  kMailboxLimit,
  kDeleteRefused,
  kWatchdogClosed,
  kProtocolError,
  kMemoryClosed,
  kLinkUp,
  kLinkDown,
  kLinkRefused,
  kLinkPath,
  kLinkRenamed,
  kUplinkChanged,
  kDuplicateAddress,
  kDuplicateRouter,
  kLoop,
  kLeaseTaken,
  kLeaseEnded,
  kDrivingRefused,
  kDenied,
  kObserved,
  kPolicyChanged,
  kRouterChanged,
  // These occur as often as messages: they are counted but not logged.
  kForgedSourceTolerated,
  kNotAvailable,
  kLifesign,
};
inline constexpr std::size_t kEventKindCount = 30;

constexpr std::array kEventKinds{
    Label<EventKind>{EventKind::kClientCame, "client_came", "a client connected"},
    Label<EventKind>{EventKind::kClientWent, "client_went", "a client disconnected"},
    Label<EventKind>{EventKind::kClientRefused, "client_refused", "a client was refused"},
    Label<EventKind>{EventKind::kRegistered, "registered", "a mailbox was registered"},
    Label<EventKind>{EventKind::kWithdrawn, "withdrawn", "a mailbox was withdrawn"},
    Label<EventKind>{EventKind::kAddressRefused, "address_refused",
                     "a mailbox was not registered: the address is in use, or of a system that the "
                     "link to its router is not for"},
    Label<EventKind>{EventKind::kMailboxLimit, "mailbox_limit",
                     "a mailbox was not registered: its client has as many as "
                     "limits.mailboxes_per_client allows, or the link to its router as many as "
                     "link.mailboxes"},
    Label<EventKind>{EventKind::kDeleteRefused, "delete_refused",
                     "a mailbox was not deleted: it belongs to another client"},
    Label<EventKind>{EventKind::kWatchdogClosed, "watchdog_closed",
                     "a client was disconnected: it did not answer the lifesign"},
    Label<EventKind>{EventKind::kProtocolError, "protocol_error",
                     "a client was disconnected: it sent an invalid message"},
    Label<EventKind>{EventKind::kMemoryClosed, "memory_closed",
                     "a client was disconnected: others needed the memory for its messages"},
    Label<EventKind>{EventKind::kLinkUp, "link_up", "a link to another router came up"},
    Label<EventKind>{EventKind::kLinkDown, "link_down",
                     "a link to another router went down; its mailboxes were withdrawn"},
    Label<EventKind>{EventKind::kLinkRefused, "link_refused", "a link was refused"},
    Label<EventKind>{EventKind::kLinkPath, "link_path",
                     "a link sends over another path from now on"},
    Label<EventKind>{EventKind::kLinkRenamed, "link_renamed",
                     "the certificate of another router names it differently from now on"},
    Label<EventKind>{EventKind::kUplinkChanged, "uplink_changed",
                     "another super router is used from now on"},
    Label<EventKind>{EventKind::kDuplicateAddress, "duplicate_address",
                     "two routers have a mailbox with the same address; the first keeps it"},
    Label<EventKind>{EventKind::kDuplicateRouter, "duplicate_router",
                     "two running routers have the same system and id; the first keeps them"},
    Label<EventKind>{EventKind::kLoop, "loop", "messages or registrations are in a loop"},
    Label<EventKind>{EventKind::kLeaseTaken, "lease_taken",
                     "somebody took the driving lease of a robot"},
    Label<EventKind>{EventKind::kLeaseEnded, "lease_ended", "the driving lease of a robot ended"},
    Label<EventKind>{EventKind::kDrivingRefused, "driving_refused",
                     "driving commands were refused: somebody else has the robot's driving lease"},
    Label<EventKind>{EventKind::kDenied, "denied", "the policy denied messages"},
    Label<EventKind>{EventKind::kObserved, "observed",
                     "messages passed that a rule with observe would deny"},
    Label<EventKind>{EventKind::kPolicyChanged, "policy_changed",
                     "the rules of the policy were replaced"},
    Label<EventKind>{EventKind::kRouterChanged, "router_changed",
                     "a client changed the router: a link, faults or a static route"},
    Label<EventKind>{EventKind::kForgedSourceTolerated, "forged_source_tolerated",
                     "a message was forwarded although its sender does not own its source address"},
    Label<EventKind>{EventKind::kNotAvailable, "not_available",
                     "a command was answered NOT_AVAILABLE: its destination is not registered"},
    Label<EventKind>{EventKind::kLifesign, "lifesign", "a lifesign was sent to a client"},
};
static_assert(complete(kEventKinds, EventKind::kLifesign) && kEventKinds.size() == kEventKindCount);
std::string_view name(EventKind kind);
std::string_view sentence(EventKind kind);

enum class CloseReason : std::uint8_t {
  kNone,
  kPeerClosed,
  kConnectionLost,
  kWatchdog,
  kTooShort,
  kTooLong,
  kBadRecord,
  kTooManyClients,
  kNoDescriptor,
  kOutOfMemory,
  kShutdown,
  kSilent,
  kReplaced,
  kForgotten,
  kAdministrative,
  kStalled,
  kLoggedOut,
  kRevoked,
  kJudged,
  kOldRoot,
};
constexpr std::array kCloseReasons{
    Label<CloseReason>{CloseReason::kNone, "none", ""},
    Label<CloseReason>{CloseReason::kPeerClosed, "peer_closed", "it closed the connection"},
    Label<CloseReason>{CloseReason::kConnectionLost, "connection_lost",
                       "its connection broke: reset, or not reachable any more"},
    Label<CloseReason>{CloseReason::kWatchdog, "watchdog", "it did not answer the lifesign"},
    Label<CloseReason>{CloseReason::kTooShort, "too_short",
                       "it sent a header with a length below 16 bytes"},
    Label<CloseReason>{CloseReason::kTooLong, "too_long",
                       "it sent a header with a length above message.max"},
    Label<CloseReason>{CloseReason::kBadRecord, "bad_record",
                       "it sent something that is not part of the protocol"},
    Label<CloseReason>{CloseReason::kTooManyClients, "too_many_clients",
                       "there are as many clients as limits.clients allows"},
    Label<CloseReason>{CloseReason::kNoDescriptor, "no_descriptor",
                       "the router had no file descriptor left for it"},
    Label<CloseReason>{CloseReason::kOutOfMemory, "out_of_memory",
                       "it did not read its messages, and others needed their memory"},
    Label<CloseReason>{CloseReason::kShutdown, "shutdown", "the router is shutting down"},
    Label<CloseReason>{CloseReason::kSilent, "silent",
                       "nothing was received from it for three keep-alive intervals"},
    Label<CloseReason>{CloseReason::kReplaced, "replaced", "it was restarted"},
    Label<CloseReason>{CloseReason::kForgotten, "forgotten", "it does not know this session"},
    Label<CloseReason>{CloseReason::kAdministrative, "administrative",
                       "the link was taken down by an operator"},
    Label<CloseReason>{
        CloseReason::kStalled, "stalled",
        "it did not complete a message, and the memory for incomplete messages was used up"},
    Label<CloseReason>{CloseReason::kLoggedOut, "logged_out",
                       "its login has ended, or the certificate behind it was revoked"},
    Label<CloseReason>{CloseReason::kRevoked, "revoked", "its certificate is revoked"},
    Label<CloseReason>{CloseReason::kJudged, "judged",
                       "rules of the policy apply to it from now on: it must connect again"},
    Label<CloseReason>{CloseReason::kOldRoot, "old_root",
                       "its certificate comes from a root that the fleet believes no longer"},
};
static_assert(complete(kCloseReasons, CloseReason::kOldRoot));
std::string_view name(CloseReason reason);
std::string_view sentence(CloseReason reason);

// Identification of a client for users, kept after the client has gone.
struct Peer {
  ClientId id{};  // kNoClient: the router itself, or none
  PortKind port = PortKind::kRouter;
  std::uint32_t pid = 0;  // 0: unknown
  Text<32> name{};
  Text<56> endpoint{};  // "127.0.0.1:54321"; empty on the local port
};

// Also kept in a log of their own, where registrations do not replace them: who was refused, what
// was denied, who has got another name, who drove, who changed the router.
constexpr bool is_audited(EventKind kind) {
  using Kind = EventKind;
  constexpr std::array kKinds{Kind::kClientRefused, Kind::kDeleteRefused,   Kind::kLinkRefused,
                              Kind::kLinkRenamed,   Kind::kDuplicateRouter, Kind::kLeaseTaken,
                              Kind::kLeaseEnded,    Kind::kDrivingRefused,  Kind::kDenied,
                              Kind::kObserved,      Kind::kPolicyChanged,   Kind::kRouterChanged};
  return std::ranges::find(kKinds, kind) != kKinds.end();
}

struct Event {
  std::uint64_t sequence = 0;  // set by the log; the first is 1
  Time at{};
  EventKind kind = EventKind::kClientCame;
  CloseReason reason = CloseReason::kNone;
  Address address{};  // of the mailbox, if any
  Peer client{};      // the client that caused the event
  Text<192> text{};   // kLinkRefused: the other router's message; kLinkPath: from, to and reason;
                      // kLinkRenamed: the former name;
                      // kLease...: whose, and why it ended; kDenied, kObserved: type and rule;
                      // kRouterChanged: what
  Peer owner{};       // kAddressRefused, kDeleteRefused: the owner of the address
};

// The newest events, in memory allocated once.
class EventLog {
 public:
  static constexpr std::size_t kCapacity = 4096;

  explicit EventLog(std::size_t capacity = kCapacity) : ring_(capacity) {}

  // Assigns a sequence number and stores the event, replacing the oldest when the log is full.
  const Event& add(const Event& event);

  [[nodiscard]] std::uint64_t last() const { return last_; }  // 0: none yet
  // Sequence number of the oldest stored event, last() + 1 when there is none.
  [[nodiscard]] std::uint64_t oldest() const {
    return last_ < ring_.size() ? 1 : last_ - ring_.size() + 1;
  }
  // Precondition: `sequence` is between oldest() and last().
  [[nodiscard]] const Event& at(std::uint64_t sequence) const {
    return ring_[sequence % ring_.size()];
  }

 private:
  std::vector<Event> ring_;
  std::uint64_t last_ = 0;
};

struct Count {
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;

  void add(std::uint64_t size) {
    ++messages;
    bytes += size;
  }
  void add(const Count& other) {
    messages += other.messages;
    bytes += other.bytes;
  }
  bool operator==(const Count&) const = default;
};

// Messages that were accepted and then lost, by class.
using LossCounts = std::array<Count, kClasses>;

// The port through which a message entered; for a message lost in a queue, the port of the queue.
class MessageCounters {
 public:
  void add(PortKind port, std::size_t message_class, Outcome outcome, std::uint64_t size) {
    cell(port, message_class, outcome).add(size);
  }
  void add(PortKind port, std::size_t message_class, Outcome outcome, const Count& count) {
    cell(port, message_class, outcome).add(count);
  }
  [[nodiscard]] const Count& of(PortKind port, std::size_t message_class, Outcome outcome) const {
    return counts_[static_cast<std::size_t>(port)][message_class]
                  [static_cast<std::size_t>(outcome)];
  }
  // Sum over all ports and classes.
  [[nodiscard]] Count total(Outcome outcome) const;

 private:
  Count& cell(PortKind port, std::size_t message_class, Outcome outcome) {
    return counts_[static_cast<std::size_t>(port)][message_class]
                  [static_cast<std::size_t>(outcome)];
  }
  std::array<std::array<std::array<Count, kOutcomeCount>, kClasses>, kPortKindCount> counts_;
};

class EventCounters {
 public:
  void add(EventKind kind) { ++counts_[static_cast<std::size_t>(kind)]; }
  [[nodiscard]] std::uint64_t of(EventKind kind) const {
    return counts_[static_cast<std::size_t>(kind)];
  }

 private:
  std::array<std::uint64_t, kEventKindCount> counts_{};
};

// Number of messages dropped within the last minute, with a resolution of one second.
class DropHistory {
 public:
  void add(Time now, std::uint64_t messages = 1);
  [[nodiscard]] std::uint64_t last_minute(Time now) const;

 private:
  struct Second {
    std::int64_t number = -1;  // seconds since the start of the clock
    std::uint64_t drops = 0;
  };
  std::array<Second, 60> seconds_;
};

}  // namespace tims::core
