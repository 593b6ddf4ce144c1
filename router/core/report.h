// Everything that can be asked about a router, as plain structs: the single source of the admin
// protocol's JSON and of /metrics. Making a report allocates and may take its time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "router/core/router.h"
#include "tims/address.h"

namespace tims::core {

// Of what was lost; what replaced it was taken.
constexpr bool is_drop(Outcome outcome) {
  return !taken(outcome) || outcome == Outcome::kMailboxReplaced;
}

struct StatusReport {
  Address address{};
  AddressWidths widths{};
  std::size_t clients = 0;
  std::size_t mailboxes = 0;
  Count forwarded{};        // delivered
  std::uint64_t drops = 0;  // all that was neither delivered nor handled, or was lost later
  std::uint64_t drops_last_minute = 0;
  std::size_t table_bytes = 0;
  std::uint64_t last_event = 0;
};
StatusReport report_status(const Router& router, Time now);

struct ClientReport {
  Peer client{};
  std::uint32_t uid = 0;
  std::uint32_t token = 0;  // to ask its port for what waits in its queue
  Duration connected{};
  std::size_t mailboxes = 0;
  bool watched = false;
  Count in{};
  Count out{};
  Count dropped{};
};
struct ClientPage {
  std::vector<ClientReport> items{};  // by number
  bool more = false;                  // there are others behind
};
// At most `limit` clients, behind `after`. Of the others nothing but the numbers is looked at.
ClientPage report_clients(const Router& router, Time now, ClientId after, std::size_t limit);

struct MailboxReport {
  Address address{};
  Peer owner{};
  std::uint32_t handle = 0;        // to ask its port about slots and fill
  std::optional<Origin> origin{};  // behind a link
  Duration age{};                  // whole seconds
};
struct MailboxPage {
  std::vector<MailboxReport> items{};  // by address
  bool more = false;                   // there may be others behind `last`
  std::optional<Address> last{};       // that was looked at
};
// At most `limit` mailboxes that match, behind `after`. What that costs is bounded, however many
// there are: a page ends after kLookedAtMax addresses although it may have few items, or none.
inline constexpr std::size_t kLookedAtMax = 64 << 10;
MailboxPage report_mailboxes(const Router& router, Time now, const AddressPattern& match,
                             std::optional<Address> after, std::size_t limit);
std::optional<MailboxReport> report_mailbox(const Router& router, Time now, Address address);

struct RouteReport {
  enum class Verdict : std::uint8_t { kDeliver, kForward, kNoRoute, kSelf };
  Verdict verdict = Verdict::kNoRoute;
  std::optional<MailboxReport> mailbox{};  // kDeliver; kForward, when it is known
  Peer link{};                             // kForward: to whom
  Address next{};                          // the router there
  Router::NextHop::By by = Router::NextHop::By::kNone;
  Outcome why_not = Outcome::kNoRoute;  // kNoRoute
  bool not_available = false;           // kNoRoute: a message of this type would be answered
};
// `from`: where the message comes from, when it is known here.
RouteReport report_route(const Router& router, Time now, Address to, std::int8_t type,
                         std::optional<Address> from = {});

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
  std::uint64_t last = 0;      // newest there is
  std::uint64_t lost = 0;      // behind `since`, and overwritten before they could be told
};
// At most `limit` events behind number `since`.
EventPage report_events(const Router& router, std::uint64_t since, std::size_t limit);

}  // namespace tims::core
