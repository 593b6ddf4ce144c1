#include "router/core/report.h"

#include <algorithm>
#include <cstdint>
#include <tuple>

namespace tims::core {
namespace {

Duration age_of(Time now, std::uint32_t registered_s) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(now.time_since_epoch());
  return seconds - std::chrono::seconds(registered_s);
}

MailboxReport describe(const Router& router, Time now, const Table::Entry& entry) {
  const Client& owner = *router.client(entry.owner);
  return {.address = entry.address,
          .owner = owner.peer(),
          .handle = entry.handle,
          .origin = owner.info.port == PortKind::kLink ? std::optional(router.origin(entry))
                                                       : std::nullopt,
          .age = age_of(now, owner.mailboxes[entry.position].registered_s)};
}

}  // namespace

StatusReport report_status(const Router& router, Time now) {
  StatusReport report{
      .address = router.settings().address,
      .widths = router.settings().widths,
      .clients = router.clients().size(),
      .mailboxes = router.table().size(),
      .forwarded = router.messages().total(Outcome::kDelivered),
      .drops_last_minute = router.drops().last_minute(now),
      .table_bytes = router.table().memory_bytes() + router.addresses().memory_bytes(),
      .last_event = router.events().last()};
  for (const Outcome outcome : values<Outcome, kOutcomeCount>()) {
    if (is_drop(outcome)) report.drops += router.messages().total(outcome).messages;
  }
  return report;
}

ClientPage report_clients(const Router& router, Time now, ClientId after, std::size_t limit) {
  std::vector<const Client*> clients;
  router.clients().for_each([&](const Client& client) {
    if (client.id > after) clients.push_back(&client);
  });
  ClientPage page{.items = {}, .more = clients.size() > limit};
  const std::size_t size = std::min(limit, clients.size());
  std::ranges::partial_sort(clients, clients.begin() + static_cast<std::ptrdiff_t>(size), {},
                            [](const Client* client) { return client->id; });
  clients.resize(size);
  page.items.reserve(size);
  for (const Client* client : clients) {
    page.items.push_back({.client = client->peer(),
                          .uid = client->info.uid,
                          .token = client->info.token,
                          .connected = now - client->connected_at,
                          .mailboxes = client->mailboxes.size(),
                          .watched = client->watched,
                          .subject = client->info.subject,
                          .is_judged = client->is_judged(),
                          .in = client->in,
                          .out = client->out,
                          .dropped = client->dropped});
  }
  return page;
}

MailboxPage report_mailboxes(const Router& router, Time now, const AddressPattern& match,
                             std::optional<Address> after, std::size_t limit) {
  MailboxPage page;
  if (after && after->raw() == UINT32_MAX) return page;
  std::size_t looked_at = 0;
  router.addresses().for_each_from(after ? Address(after->raw() + 1) : Address(0), [&](Address at) {
    page.more = page.items.size() == limit || looked_at == kLookedAtMax;
    if (page.more) return false;
    ++looked_at;
    page.last = at;
    if (match.matches(at)) page.items.push_back(describe(router, now, *router.find(at)));
    return true;
  });
  return page;
}

std::optional<MailboxReport> report_mailbox(const Router& router, Time now, Address address) {
  const Table::Entry* entry = router.find(address);
  if (entry == nullptr) return std::nullopt;
  return describe(router, now, *entry);
}

RouteReport report_route(const Router& router, Time now, Address to, std::int8_t type,
                         std::optional<Address> from, policy::Right right) {
  using Verdict = RouteReport::Verdict;
  const bool is_self = to == router.settings().address;
  if (is_self && right == policy::Right::kNone) return {.verdict = Verdict::kSelf};
  const Table::Entry* source = from ? router.find(*from) : nullptr;
  const Client* sender = source == nullptr ? nullptr : router.client(source->owner);
  if (sender != nullptr && sender->is_judged()) {
    const VerdictReport report = report_verdict(
        router, sender->info.subject, {.dest = to, .src = *from, .type = type, .right = right}, 0);
    if (report.action == policy::Action::kDeny)
      return {.verdict = Verdict::kDenied, .not_available = type > 0, .denied = report};
  }
  if (is_self) return {.verdict = Verdict::kSelf};
  const NextHop hop = router.routes().next_hop(sender, to);
  if (hop.to == nullptr)
    return {.verdict = Verdict::kNoRoute, .why_not = hop.why_not, .not_available = type > 0};
  const bool link = hop.to->info.port == PortKind::kLink;
  return {.verdict = link ? Verdict::kForward : Verdict::kDeliver,
          .mailbox = report_mailbox(router, now, to),
          .link = link ? hop.to->peer() : Peer{},
          .next = link ? hop.to->info.link.router : Address(),
          .by = hop.by};
}

std::vector<CountReport> report_counts(const Router& router) {
  std::vector<CountReport> reports;
  for (const PortKind port : values<PortKind, kPortKindCount>()) {
    for (std::size_t message_class = 0; message_class < kClasses; ++message_class) {
      for (const Outcome outcome : values<Outcome, kOutcomeCount>()) {
        const Count& count = router.messages().of(port, message_class, outcome);
        if (count.messages == 0) continue;
        reports.push_back({port, message_class, outcome, count});
      }
    }
  }
  return reports;
}

std::vector<EventCountReport> report_event_counts(const Router& router) {
  std::vector<EventCountReport> reports;
  for (const EventKind kind : values<EventKind, kEventKindCount>()) {
    reports.push_back({kind, router.event_counts().of(kind)});
  }
  return reports;
}

EventPage report_events(const EventLog& log, std::uint64_t since, std::size_t limit) {
  EventPage page{.items = {}, .last = log.last()};
  // A number from before a restart of the router means "from the beginning".
  if (since > log.last()) since = 0;
  const std::uint64_t first = std::max(since + 1, log.oldest());
  page.lost = first - (since + 1);
  for (std::uint64_t i = first; i <= log.last() && page.items.size() < limit; ++i) {
    page.items.push_back(log.at(i));
  }
  return page;
}

std::vector<RuleReport> report_rules(const Router& router) {
  std::vector<RuleReport> reports;
  if (router.policy() == nullptr) return reports;
  const policy::Policy& policy = router.policy()->policy();
  for (std::size_t i = 0; i < policy.rules().size(); ++i) {
    const auto number = static_cast<policy::RuleNumber>(i);
    reports.push_back({number, policy.rule(number).text, router.policy()->hits(number)});
  }
  return reports;
}

VerdictReport report_verdict(const Router& router, const policy::Subject& sender,
                             const policy::Query& query, std::uint8_t priority) {
  const policy::Policy& policy = router.policy()->policy();
  const policy::Rule& rule = policy.rule(policy.decide(sender, query));
  return {.action = rule.action,
          .rule = rule.text,
          .priority = std::min(priority, rule.text.priority_max),
          .subject = sender.name};
}

std::vector<StreamReport> report_streams(const Router& router, const AddressPattern& match,
                                         std::optional<Address> to) {
  std::vector<StreamReport> reports;
  router.clients().for_each([&](const Client& client) {
    const StreamCounters* streams =
        client.keeps_newest ? router.streams(client.info.port, client.info.token) : nullptr;
    if (streams == nullptr) return;
    streams->for_each([&](const StreamCounters::Stream& stream) {
      if (match.matches(stream.src) && (!to || stream.dest == *to))
        reports.push_back({client.id, stream});
    });
  });
  std::ranges::sort(reports, {}, [](const StreamReport& report) {
    return std::tuple(report.client, report.stream.src.raw(), report.stream.dest.raw(),
                      report.stream.type);
  });
  return reports;
}

}  // namespace tims::core
