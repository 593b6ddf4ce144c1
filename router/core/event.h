// What happened to clients and mailboxes: counted by kind, and the newest kept for
// `timsctl route watch`.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "router/core/ids.h"
#include "router/core/labels.h"
#include "router/core/text.h"
#include "tims/address.h"
#include "tims/time.h"

namespace tims::core {

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
  kLinkUp,
  kLinkDown,
  kLinkRefused,
  kLinkPath,
  kUplinkChanged,
  kDuplicateAddress,
  kDuplicateRouter,
  kLoop,
  kForgedSourceTolerated,
  kNotAvailable,
  kLifesign,
};
inline constexpr std::size_t kEventKindCount = 21;

constexpr std::array kEventKinds{
    Label<EventKind>{EventKind::kClientCame, "client_came", "a client connected"},
    Label<EventKind>{EventKind::kClientWent, "client_went", "a client went away"},
    Label<EventKind>{EventKind::kClientRefused, "client_refused", "a client was turned away"},
    Label<EventKind>{EventKind::kRegistered, "registered", "a mailbox was registered"},
    Label<EventKind>{EventKind::kWithdrawn, "withdrawn", "a mailbox went away"},
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
                     "a client was disconnected: what it sent is no message"},
    Label<EventKind>{EventKind::kLinkUp, "link_up", "a link to another router came up"},
    Label<EventKind>{EventKind::kLinkDown, "link_down",
                     "a link to another router went down; its mailboxes were withdrawn"},
    Label<EventKind>{EventKind::kLinkRefused, "link_refused", "a link was refused"},
    Label<EventKind>{EventKind::kLinkPath, "link_path",
                     "what is sent over a link goes another way from now on"},
    Label<EventKind>{EventKind::kUplinkChanged, "uplink_changed",
                     "another super router is used from now on"},
    Label<EventKind>{EventKind::kDuplicateAddress, "duplicate_address",
                     "two routers have a mailbox with the same address; the first keeps it"},
    Label<EventKind>{EventKind::kDuplicateRouter, "duplicate_router",
                     "two living routers have the same system and id; the first keeps them"},
    Label<EventKind>{EventKind::kLoop, "loop", "messages or registrations go round in a loop"},
    Label<EventKind>{EventKind::kForgedSourceTolerated, "forged_source_tolerated",
                     "a message was forwarded although its sender does not own its source address"},
    Label<EventKind>{EventKind::kNotAvailable, "not_available",
                     "a command was answered NOT_AVAILABLE: nobody has registered its destination"},
    Label<EventKind>{EventKind::kLifesign, "lifesign", "a client was asked whether it still lives"},
};
static_assert(complete(kEventKinds, EventKind::kLifesign) && kEventKinds.size() == kEventKindCount);
std::string_view name(EventKind kind);
std::string_view sentence(EventKind kind);
// The others come with messages, as often as those: they are counted and nothing else.
constexpr bool kept(EventKind k) { return k < EventKind::kForgedSourceTolerated; }

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
};
constexpr std::array kCloseReasons{
    Label<CloseReason>{CloseReason::kNone, "none", ""},
    Label<CloseReason>{CloseReason::kPeerClosed, "peer_closed", "it closed the connection"},
    Label<CloseReason>{CloseReason::kConnectionLost, "connection_lost",
                       "its connection broke: reset, or not reachable any more"},
    Label<CloseReason>{CloseReason::kWatchdog, "watchdog", "it did not answer the lifesign"},
    Label<CloseReason>{CloseReason::kTooShort, "too_short",
                       "it sent a header that says less than 16 bytes"},
    Label<CloseReason>{CloseReason::kTooLong, "too_long",
                       "it sent a header that says more than message.max"},
    Label<CloseReason>{CloseReason::kBadRecord, "bad_record",
                       "it sent something that is not part of the protocol"},
    Label<CloseReason>{CloseReason::kTooManyClients, "too_many_clients",
                       "there are as many clients as limits.clients allows"},
    Label<CloseReason>{CloseReason::kNoDescriptor, "no_descriptor",
                       "the router had no file descriptor left for it"},
    Label<CloseReason>{CloseReason::kOutOfMemory, "out_of_memory",
                       "no memory was left for what it had not read yet"},
    Label<CloseReason>{CloseReason::kShutdown, "shutdown", "the router ends"},
    Label<CloseReason>{CloseReason::kSilent, "silent",
                       "nothing was heard of it for three keep-alive intervals"},
    Label<CloseReason>{CloseReason::kReplaced, "replaced", "it was started anew"},
    Label<CloseReason>{CloseReason::kForgotten, "forgotten", "it does not know this session"},
    Label<CloseReason>{CloseReason::kAdministrative, "administrative",
                       "somebody took the link down"},
    Label<CloseReason>{CloseReason::kStalled, "stalled",
                       "it did not end a message, and the memory for such messages was used up"},
};
static_assert(complete(kCloseReasons, CloseReason::kStalled));
std::string_view name(CloseReason reason);
std::string_view sentence(CloseReason reason);

// A client as people know it, kept after it has gone.
struct Party {
  ClientId id{};  // kNoClient: the router itself, or nobody
  PortKind port = PortKind::kRouter;
  std::uint32_t pid = 0;  // 0: not known
  Text<31> name{};
  Text<55> peer{};  // "127.0.0.1:54321"; empty on the local port
};

struct Event {
  std::uint64_t sequence = 0;  // set by the log; the first is 1
  Time at{};
  EventKind kind = EventKind::kClientCame;
  CloseReason reason = CloseReason::kNone;
  Address address{};  // of the mailbox, where there is one
  Party client{};     // whose doing it was
  Text<191> text{};   // kLinkRefused: what the other router said; kLinkPath: from, to and why
  Party owner{};      // kAddressRefused, kDeleteRefused: to whom the address belongs
};

// The newest events, in memory reserved once.
class EventLog {
 public:
  static constexpr std::size_t kCapacity = 4096;

  EventLog() : ring_(kCapacity) {}

  // Numbers the event and keeps it, in place of the oldest when there are too many.
  const Event& add(const Event& event);

  [[nodiscard]] std::uint64_t last() const { return last_; }  // 0: none yet
  // Number of the oldest event that is still here, last() + 1 when there is none.
  [[nodiscard]] std::uint64_t oldest() const {
    return last_ < kCapacity ? 1 : last_ - kCapacity + 1;
  }
  // `sequence` from oldest() to last().
  [[nodiscard]] const Event& at(std::uint64_t sequence) const {
    return ring_[sequence % kCapacity];
  }

 private:
  std::vector<Event> ring_;
  std::uint64_t last_ = 0;
};

}  // namespace tims::core
