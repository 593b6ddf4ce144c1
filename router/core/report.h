// All reports about a router, as plain structs: the single source of the admin protocol's JSON
// and of /metrics. Creating a report allocates and may be slow.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "router/core/router.h"
#include "tims/address.h"

namespace tims::core {

// True when the message was lost. For a replaced message, the newer one was accepted.
constexpr bool is_drop(Outcome outcome) {
  return !taken(outcome) || outcome == Outcome::kMailboxReplaced;
}

struct StatusReport {
  Address address{};
  AddressWidths widths{};
  std::size_t clients = 0;
  std::size_t mailboxes = 0;
  Count forwarded{};        // delivered
  std::uint64_t drops = 0;  // neither delivered nor handled, or lost later
  std::uint64_t drops_last_minute = 0;
  std::size_t table_bytes = 0;
  std::uint64_t last_event = 0;
};
StatusReport report_status(const Router& router, Time now);

struct ClientReport {
  Peer client{};
  std::uint32_t uid = 0;
  std::uint32_t token = 0;  // to ask its port for the bytes in its queue
  Duration connected{};
  std::size_t mailboxes = 0;
  bool watched = false;
  policy::Subject subject{};  // who it is, for rules of the policy
  bool is_judged = false;     // rules apply to it
  Count in{};
  Count out{};
  Count dropped{};
};
struct ClientPage {
  std::vector<ClientReport> items{};  // by number
  bool more = false;                  // more clients follow
};
// At most `limit` clients after `after`. Only the numbers of the others are examined.
ClientPage report_clients(const Router& router, Time now, ClientId after, std::size_t limit);

struct MailboxReport {
  Address address{};
  Peer owner{};
  std::uint32_t handle = 0;        // to ask its port for slots and fill
  std::optional<Origin> origin{};  // set when it is behind a link
  Duration age{};                  // whole seconds
};
struct MailboxPage {
  std::vector<MailboxReport> items{};  // by address
  bool more = false;                   // more may follow after `last`
  std::optional<Address> last{};       // the last address examined
};
// At most `limit` mailboxes that match, after `after`. The cost is bounded whatever the number of
// mailboxes: a page ends after kLookedAtMax addresses, even with few or no items.
inline constexpr std::size_t kLookedAtMax = 64 << 10;
MailboxPage report_mailboxes(const Router& router, Time now, const AddressPattern& match,
                             std::optional<Address> after, std::size_t limit);
std::optional<MailboxReport> report_mailbox(const Router& router, Time now, Address address);

// What the policy says.
struct VerdictReport {
  policy::Action action = policy::Action::kAllow;
  policy::RuleText rule{};
  std::uint8_t priority = 0;  // that the message goes on with
  std::string subject{};      // whom the rules were asked for
};
// Precondition: the router has a policy.
VerdictReport report_verdict(const Router& router, const policy::Subject& sender,
                             const policy::Query& query, std::uint8_t priority);

struct RouteReport {
  enum class Verdict : std::uint8_t { kDeliver, kForward, kNoRoute, kSelf, kDenied };
  Verdict verdict = Verdict::kNoRoute;
  std::optional<MailboxReport> mailbox{};  // set for kDeliver, and for kForward when it is known
  Peer link{};                             // kForward: the link used
  Address next{};                          // the router at its other end
  NextHop::By by = NextHop::By::kNone;
  Outcome why_not = Outcome::kNoRoute;  // kNoRoute
  bool not_available = false;           // kNoRoute, kDenied: this type would be answered so
  VerdictReport denied{};               // kDenied
};
// `from`: the source of the message, when it is registered here. `right`: what a question to a
// router needs.
RouteReport report_route(const Router& router, Time now, Address to, std::int8_t type,
                         std::optional<Address> from = {},
                         policy::Right right = policy::Right::kNone);

struct CountReport {
  PortKind port = PortKind::kTcp;
  std::size_t message_class = 0;
  Outcome outcome = Outcome::kDelivered;
  Count count{};
};
std::vector<CountReport> report_counts(const Router& router);  // those that are not 0

struct EventCountReport {
  EventKind kind = EventKind::kClientCame;
  std::uint64_t count = 0;
};
std::vector<EventCountReport> report_event_counts(const Router& router);

struct EventPage {
  std::vector<Event> items{};  // oldest first
  std::uint64_t last = 0;      // the newest existing
  std::uint64_t lost = 0;      // after `since`, and overwritten before they could be reported
};
// At most `limit` events after number `since`.
EventPage report_events(const EventLog& log, std::uint64_t since, std::size_t limit);

// A rule of the policy, built-in ones included.
struct RuleReport {
  policy::RuleNumber number = 0;
  policy::RuleText rule{};
  policy::Hits hits{};
};
std::vector<RuleReport> report_rules(const Router& router);

// A stream to a client that keeps the newest samples only.
struct StreamReport {
  ClientId client{};
  StreamCounters::Stream stream{};
};
// Those of sources that match, to the mailbox `to` if it is given; in order of clients, sources
// and destinations.
std::vector<StreamReport> report_streams(const Router& router, const AddressPattern& match,
                                         std::optional<Address> to);

}  // namespace tims::core
