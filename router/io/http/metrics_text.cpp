#include "router/io/http/metrics_text.h"

#include <array>
#include <chrono>
#include <initializer_list>
#include <utility>

#include <fmt/format.h>

#include "router/core/report.h"

namespace tims::io {
namespace {

using core::Outcome;
using Labels = std::initializer_list<std::pair<std::string_view, std::string_view>>;

// A value ends at the quote; of all texts only the router's name could have one in it.
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

class Page {
 public:
  // What the samples that follow belong to.
  void family(std::string_view name, std::string_view type, std::string_view help) {
    name_ = name;
    text_ += fmt::format("# HELP {} {}\n# TYPE {} {}\n", name, help, name, type);
  }
  template <typename Number>
  void sample(Number value, Labels labels = {}) {
    text_ += name_;
    char before = '{';
    for (const auto& [label, text] : labels) {
      text_ += fmt::format("{}{}=\"{}\"", before, label, escaped(text));
      before = ',';
    }
    text_ += fmt::format("{} {}\n", labels.size() == 0 ? "" : "}", value);
  }
  std::string take() { return std::move(text_); }

 private:
  std::string_view name_;
  std::string text_;
};

double seconds(Duration duration) { return std::chrono::duration<double>(duration).count(); }

bool is_drop(Outcome outcome) {
  return !core::taken(outcome) || outcome == Outcome::kMailboxReplaced;
}

void add_messages(Page& page, const core::Router& router) {
  const auto reports = core::report_counts(router);
  const auto add = [&](auto value) {
    for (const core::CountReport& report : reports)
      page.sample(value(report.count), {{"port", core::name(report.port)},
                                        {"class", std::to_string(report.message_class)},
                                        {"outcome", core::name(report.outcome)}});
  };
  page.family("tims_router_messages_total", "counter",
              "Messages by the port they came through, priority class (0 to 7) and outcome.");
  add([](const core::Count& count) { return count.messages; });
  page.family("tims_router_message_bytes_total", "counter",
              "Bytes of these messages, headers included.");
  add([](const core::Count& count) { return count.bytes; });
}

// Also those that have not happened yet: a first drop shall be seen as a change from 0.
void add_drops_and_events(Page& page, const core::Router& router) {
  page.family("tims_router_drops_total", "counter", "Messages that were lost, by reason.");
  for (const auto& label : core::kOutcomes)
    if (is_drop(label.value))
      page.sample(router.messages().total(label.value).messages, {{"reason", label.name}});
  page.family("tims_router_events_total", "counter",
              "What happened to clients and mailboxes, by kind.");
  for (const core::EventCountReport& report : core::report_event_counts(router))
    page.sample(report.count, {{"event", core::name(report.kind)}});
}

void add_mailboxes(Page& page, const MailboxCounts& counts) {
  page.family("tims_mailbox_messages_total", "counter",
              "Messages to mailboxes in shared memory, whoever sent them, by what became of them.");
  page.sample(counts.received, {{"outcome", "received"}});
  page.sample(counts.replaced, {{"outcome", "replaced"}});
  page.sample(counts.refused, {{"outcome", "refused"}});
  page.sample(counts.too_big, {{"outcome", "too_big"}});
  page.sample(counts.reclaimed, {{"outcome", "reclaimed"}});
}

void add_clients(Page& page, const AdminSource& source) {
  struct Use {
    std::size_t clients = 0;
    std::uint64_t queued = 0;
  };
  std::array<Use, core::kPortKinds.size()> uses;
  source.router().clients().for_each([&](const core::Client& client) {
    Use& use = uses[static_cast<std::size_t>(client.info.port)];
    ++use.clients;
    use.queued += source.queued_bytes(client.info.port, client.info.token);
  });
  const auto add = [&](auto Use::*value) {
    for (const auto& port : core::kPortKinds)
      if (port.value != core::PortKind::kRouter)
        page.sample(uses[static_cast<std::size_t>(port.value)].*value, {{"port", port.name}});
  };
  page.family("tims_router_clients", "gauge", "Clients that are connected, by port.");
  add(&Use::clients);
  page.family("tims_router_queued_bytes", "gauge",
              "What waits in the router for clients that read slowly, by port.");
  add(&Use::queued);
}

// By the other router's name: few, and they do not change.
void add_links(Page& page, const AdminSource& source) {
  const link::Links* links = source.links();
  if (links == nullptr) return;
  const auto add = [&](auto value) {
    links->for_each([&](const link::Link& link) {
      const std::string_view name =
          link.peer().epoch == 0 ? link.settings().to : link.peer().name.view();
      page.sample(value(link), {{"link", name}, {"kind", core::name(link.settings().kind)}});
    });
  };
  page.family("tims_link_up", "gauge", "1 while messages pass over the link.");
  add([](const link::Link& link) { return link.is_up() ? 1 : 0; });
  page.family("tims_link_rtt_seconds", "gauge", "Round trip to the router at its other end.");
  add([](const link::Link& link) { return seconds(link.rtt().smoothed()); });
  page.family("tims_link_queue_bytes", "gauge", "What waits for the link, or to be acknowledged.");
  add([](const link::Link& link) { return link.session().queued_bytes(); });
  page.family("tims_link_packets_lost_total", "counter", "Packets that did not arrive there.");
  add([](const link::Link& link) { return link.session().counters().packets_lost; });
  page.family("tims_link_sent_bytes_total", "counter", "Bytes of the datagrams that were sent.");
  add([](const link::Link& link) { return link.session().counters().bytes_out; });
  page.family("tims_link_received_bytes_total", "counter", "Bytes of the datagrams that came.");
  add([](const link::Link& link) { return link.session().counters().bytes_in; });
}

void add_process(Page& page, const ProcessReport& process, const core::StatusReport& status) {
  page.family("tims_router_mailboxes", "gauge", "Mailboxes that are registered.");
  page.sample(status.mailboxes);
  page.family("tims_router_table_bytes", "gauge", "Memory of the table of mailboxes.");
  page.sample(status.table_bytes);
  page.family("tims_router_uptime_seconds", "gauge", "Time since the router was started.");
  page.sample(seconds(process.uptime));
  page.family("tims_router_longest_turn_seconds", "gauge",
              "Longest turn of the event loop: so long have others had to wait.");
  page.sample(seconds(process.longest_turn));
  page.family("process_resident_memory_bytes", "gauge", "Memory of the router's process.");
  page.sample(process.rss_bytes);
  page.family("tims_router_info", "gauge", "Always 1; who this router is.");
  page.sample(1, {{"name", process.name},
                  {"address", status.address.to_string(status.widths)},
                  {"version", process.version}});
}

}  // namespace

std::string metrics_text(const AdminSource& source, Time now) {
  Page page;
  add_messages(page, source.router());
  add_drops_and_events(page, source.router());
  add_mailboxes(page, source.mailbox_counts());
  add_clients(page, source);
  add_links(page, source);
  add_process(page, source.process(now), core::report_status(source.router(), now));
  return page.take();
}

}  // namespace tims::io
