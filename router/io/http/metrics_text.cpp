#include "router/io/http/metrics_text.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "router/core/report.h"
#include "router/io/reports.h"

namespace tims::io {
namespace {

using core::Outcome;
using Labels = std::vector<std::pair<std::string_view, std::string>>;

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

// Each metric of these reports, a sample a report. `for_each` takes a function of a report.
template <typename Report, typename ForEach, typename LabelsOf>
void add_reports(Page& page, ForEach for_each, LabelsOf labels_of) {
  for_each_metric<Report>([&](const Metric& metric, auto get) {
    page.family(metric.name, metric.type, metric.help);
    for_each([&](const Report& report) { page.sample(get(report), labels_of(report)); });
  });
}

bool is_drop(Outcome outcome) {
  return !core::taken(outcome) || outcome == Outcome::kMailboxReplaced;
}

void add_messages(Page& page, const core::Router& router) {
  const auto reports = core::report_counts(router);
  add_reports<core::CountReport>(
      page, [&](auto sample) { std::ranges::for_each(reports, sample); },
      [](const core::CountReport& report) -> Labels {
        return {{"port", std::string(core::name(report.port))},
                {"class", std::to_string(report.message_class)},
                {"outcome", std::string(core::name(report.outcome))}};
      });
}

// Also those that have not happened yet: a first drop shall be seen as a change from 0.
void add_drops_and_events(Page& page, const core::Router& router) {
  page.family("tims_router_drops_total", "counter", "Messages that were lost, by reason.");
  for (const auto& label : core::kOutcomes)
    if (is_drop(label.value))
      page.sample(router.messages().total(label.value).messages,
                  {{"reason", std::string(label.name)}});
  page.family("tims_router_events_total", "counter",
              "What happened to clients and mailboxes, by kind.");
  for (const core::EventCountReport& report : core::report_event_counts(router))
    page.sample(report.count, {{"event", std::string(core::name(report.kind))}});
}

void add_mailboxes(Page& page, const MailboxCounts& counts) {
  page.family("tims_mailbox_messages_total", "counter",
              "Messages to mailboxes in shared memory, whoever sent them, by what became of them.");
  for_each_field<MailboxCounts>([&](const auto& field) {
    page.sample(std::invoke(field.get, counts), {{"outcome", std::string(field.name)}});
  });
}

void add_clients(Page& page, const AdminSource& source) {
  std::vector<PortUse> uses;
  uses.reserve(core::kPortKinds.size());
  for (const auto& port : core::kPortKinds) uses.push_back({.port = port.value});
  source.router().clients().for_each([&](const core::Client& client) {
    PortUse& use = uses[static_cast<std::size_t>(client.info.port)];
    ++use.clients;
    use.queued_bytes += source.queued_bytes(client.info.port, client.info.token);
  });
  std::erase_if(uses, [](const PortUse& use) { return use.port == core::PortKind::kRouter; });
  add_reports<PortUse>(
      page, [&](auto sample) { std::ranges::for_each(uses, sample); },
      [](const PortUse& use) -> Labels {
        return {{"port", std::string(core::name(use.port))}};
      });
}

// By the other router's name: few, and they do not change.
void add_links(Page& page, const AdminSource& source, Time now) {
  const link::Links* links = source.links();
  if (links == nullptr) return;
  add_reports<LinkView>(
      page,
      [&](auto sample) {
        links->for_each(
            [&](const link::Link& link) { sample(LinkView(*links, link, source.router(), now)); });
      },
      [](const LinkView& v) -> Labels {
        const std::string_view name =
            v.is_known() ? v.link.peer().name.view() : std::string_view(v.link.settings().to);
        return {{"link", std::string(name)},
                {"kind", std::string(core::name(v.link.settings().kind))}};
      });
}

void add_process(Page& page, const ProcessReport& process, const core::StatusReport& status) {
  add_reports<StatusView>(
      page,
      [&](auto sample) {
        sample(StatusView{status, process});
      },
      [](const StatusView&) { return Labels(); });
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
  add_links(page, source, now);
  add_process(page, source.process(now), core::report_status(source.router(), now));
  return page.take();
}

}  // namespace tims::io
