#include "router/io/metrics.h"

#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "router/core/report.h"

namespace tims::io {
namespace {

using base::seconds;
using Labels = std::vector<std::pair<std::string_view, std::string>>;

// A label value ends at the quote; names of routers and rules may contain one.
std::string escaped(std::string_view value) {
  std::string text;
  for (const char c : value) {
    if (c == '\\' || c == '"') text += '\\';
    if (c == '\n')
      text += "\\n";
    else
      text += c;
  }
  return text;
}

class MetricsPage {
 public:
  // A metric with one sample of each report.
  void add(std::string_view name, std::string_view type, std::string_view help, const auto& reports,
           auto labels_of, auto value_of) {
    family(name, type, help);
    for (const auto& report : reports) sample(value_of(report), labels_of(report));
  }
  // Starts a metric; the following samples belong to it.
  void family(std::string_view name, std::string_view type, std::string_view help) {
    name_ = name;
    text_ += fmt::format("# HELP {} {}\n# TYPE {} {}\n", name, help, name, type);
  }
  template <typename Number>
  void sample(Number value, const Labels& labels = {}) {
    text_ += name_;
    char before = '{';
    for (const auto& [label, text] : labels) {
      text_ += fmt::format("{}{}=\"{}\"", before, label, escaped(text));
      before = ',';
    }
    text_ += fmt::format("{} {}\n", labels.empty() ? "" : "}", value);
  }
  std::string take() { return std::move(text_); }

 private:
  std::string_view name_;
  std::string text_;
};

void add_messages(MetricsPage& page, const core::Router& router) {
  const auto reports = core::report_counts(router);
  const auto labels = [](const core::CountReport& report) -> Labels {
    return {{"port", std::string(core::name(report.port))},
            {"class", std::to_string(report.message_class)},
            {"outcome", std::string(core::name(report.outcome))}};
  };
  page.add("tims_router_messages_total", "counter",
           "Messages by the port they came through, priority class (0 to 7) and outcome.", reports,
           labels, [](const auto& report) { return report.count.messages; });
  page.add("tims_router_message_bytes_total", "counter",
           "Bytes of these messages, headers included.", reports, labels,
           [](const auto& report) { return report.count.bytes; });
}

// Includes counters that are 0, so that a first drop is visible as a change from 0.
void add_drops_and_events(MetricsPage& page, const core::Router& router) {
  page.family("tims_router_drops_total", "counter", "Messages that were lost, by reason.");
  for (const auto& label : core::kOutcomes)
    if (core::is_drop(label.value))
      page.sample(router.messages().total(label.value).messages,
                  {{"reason", std::string(label.name)}});
  page.family("tims_router_events_total", "counter", "Events of clients and mailboxes, by kind.");
  for (const core::EventCountReport& report : core::report_event_counts(router))
    page.sample(report.count, {{"event", std::string(core::name(report.kind))}});
}

void add_rules(MetricsPage& page, const core::Router& router) {
  page.family("tims_router_rule_messages_total", "counter",
              "Messages that a rule of the policy has matched, by what became of them.");
  for (const core::RuleReport& report : core::report_rules(router)) {
    const policy::Hits& hits = report.hits;
    const auto sample = [&](std::uint64_t messages, std::string_view outcome) {
      page.sample(messages, {{"rule", report.rule.name}, {"outcome", std::string(outcome)}});
    };
    sample(hits.messages - hits.denied - hits.thinned, "passed");
    sample(hits.denied, "denied");
    sample(hits.thinned, "thinned");
  }
}

void add_mailboxes(MetricsPage& page, const shm::Counters& counts) {
  page.family("tims_mailbox_messages_total", "counter",
              "Messages to mailboxes in shared memory, from all senders, by outcome.");
  page.sample(counts.received, {{"outcome", "received"}});
  page.sample(counts.replaced, {{"outcome", "replaced"}});
  page.sample(counts.refused, {{"outcome", "refused"}});
  page.sample(counts.too_big, {{"outcome", "too_big"}});
  page.sample(counts.reclaimed, {{"outcome", "reclaimed"}});
}

// Totals of all clients of one port.
struct PortUse {
  core::PortKind port{};
  std::size_t clients = 0;
  std::uint64_t queued_bytes = 0;
};

void add_clients(MetricsPage& page, const AdminSource& source) {
  std::vector<PortUse> uses;
  uses.reserve(core::kPortKinds.size());
  for (const auto& port : core::kPortKinds) uses.push_back({.port = port.value});
  source.router().clients().for_each([&](const core::Client& client) {
    PortUse& use = uses[static_cast<std::size_t>(client.info.port)];
    ++use.clients;
    use.queued_bytes += source.queued_bytes(client.info.port, client.info.token);
  });
  std::erase_if(uses, [](const PortUse& use) { return use.port == core::PortKind::kRouter; });
  const auto labels = [](const PortUse& use) -> Labels {
    return {{"port", std::string(core::name(use.port))}};
  };
  page.add("tims_router_clients", "gauge", "Clients that are connected, by port.", uses, labels,
           [](const PortUse& use) { return use.clients; });
  page.add("tims_router_queued_bytes", "gauge",
           "Bytes queued in the router for clients that read slowly, by port.", uses, labels,
           [](const PortUse& use) { return use.queued_bytes; });
}

void add_links(MetricsPage& page, const link::Links& links) {
  std::vector<const link::Link*> all;
  links.for_each([&](const link::Link& link) { all.push_back(&link); });
  const auto add = [&](std::string_view name, std::string_view type, std::string_view help,
                       auto value_of) {
    page.add(
        name, type, help, all,
        [](const link::Link* link) -> Labels {
          const auto& peer = link->peer();
          return {{"link", peer.epoch != 0 ? std::string(peer.name.view()) : link->settings().to},
                  {"kind", std::string(core::name(link->settings().kind))}};
        },
        [&](const link::Link* link) { return value_of(*link); });
  };
  add("tims_link_up", "gauge", "1 while messages pass over the link.",
      [](const link::Link& link) { return link.is_up() ? 1 : 0; });
  add("tims_link_rtt_seconds", "gauge", "Round trip to the router at its other end.",
      [](const link::Link& link) { return seconds(link.rtt().smoothed()); });
  add("tims_link_queue_bytes", "gauge", "What waits for the link, or to be acknowledged.",
      [](const link::Link& link) { return link.session().queued_bytes(); });
  add("tims_link_packets_lost_total", "counter", "Packets that did not arrive there.",
      [](const link::Link& link) { return link.session().counters().packets_lost; });
  add("tims_link_packets_forged_total", "counter",
      "Packets that the keys of the link do not open: of somebody else, or altered.",
      [](const link::Link& link) { return link.session().counters().packets_forged; });
  add("tims_link_sent_bytes_total", "counter", "Bytes of the datagrams that were sent.",
      [](const link::Link& link) { return link.session().counters().bytes_out; });
  add("tims_link_received_bytes_total", "counter", "Bytes of the datagrams that came.",
      [](const link::Link& link) { return link.session().counters().bytes_in; });
}

void add_strangers(MetricsPage& page, const link::Links::Counters& counters) {
  page.family("tims_links_refused_total", "counter",
              "Datagrams that no link has sent, and routers that asked for a link in vain.");
  page.sample(counters.strange, {{"reason", "strange"}});
  page.sample(counters.unknown_token, {{"reason", "unknown_token"}});
  page.sample(counters.refused, {{"reason", "refused"}});
  const link::Handshakes::Counters& handshakes = counters.handshakes;
  page.family("tims_handshakes", "gauge",
              "Handshakes of routers that ask for a link, in progress.");
  page.sample(handshakes.in_progress);
  page.family(
      "tims_handshakes_total", "counter",
      "Those that have begun and how they ended, and datagrams that found no room for one.");
  page.sample(handshakes.accepted, {{"what", "accepted"}});
  page.sample(handshakes.answered, {{"what", "answered"}});
  page.sample(handshakes.given_up, {{"what", "given_up"}});
  page.sample(handshakes.turned_away, {{"what", "turned_away"}});
}

void add_refusals(MetricsPage& page, const HttpRefusals& refused) {
  page.family("tims_http_refusals_total", "counter",
              "Requests from browsers that were refused, by the rule they violated.");
  page.sample(refused.host, {{"rule", "host"}});
  page.sample(refused.origin, {{"rule", "origin"}});
  page.sample(refused.cross_site, {{"rule", "cross_site"}});
}

void add_process(MetricsPage& page, const ProcessReport& process,
                 const core::StatusReport& status) {
  const auto gauge = [&](std::string_view name, std::string_view help, auto value) {
    page.family(name, "gauge", help);
    page.sample(value);
  };
  gauge("tims_router_mailboxes", "Mailboxes that are registered.", status.mailboxes);
  gauge("tims_router_table_bytes", "Memory of the table of mailboxes.", status.table_bytes);
  gauge("tims_router_uptime_seconds", "Time since the router was started.",
        seconds(process.uptime));
  gauge("tims_router_longest_turn_seconds",
        "Longest turn of the event loop: so long have others had to wait.",
        seconds(process.longest_turn));
  gauge("process_resident_memory_bytes", "Memory of the router's process.", process.rss_bytes);
  page.family("tims_router_info", "gauge", "Always 1; labels identify this router.");
  page.sample(1, {{"name", process.name},
                  {"address", status.address.to_string(status.widths)},
                  {"version", process.version}});
}

}  // namespace

std::string metrics_text(const AdminSource& source, Time now) {
  MetricsPage page;
  add_messages(page, source.router());
  add_drops_and_events(page, source.router());
  add_rules(page, source.router());
  add_mailboxes(page, source.mailbox_counts());
  add_clients(page, source);
  if (const link::Links* links = source.links()) {
    add_links(page, *links);
    add_strangers(page, links->counters());
  }
  const ProcessReport process = source.process(now);
  add_refusals(page, process.http_refused);
  add_process(page, process, core::report_status(source.router(), now));
  return page.take();
}

}  // namespace tims::io
