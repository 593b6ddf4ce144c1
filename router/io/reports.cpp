#include "router/io/reports.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace tims::io {
namespace {

namespace json = boost::json;
using base::valid_utf8;
using By = core::Router::NextHop::By;
using Labels = std::vector<std::pair<std::string_view, std::string>>;

std::string peer_text(const core::Peer& peer) {
  std::string text(peer.name.view());
  if (text.empty())
    text = peer.endpoint.empty() ? "client " + std::to_string(peer.id.value)
                                 : std::string(peer.endpoint.view());
  if (peer.pid != 0) text += " (pid " + std::to_string(peer.pid) + ")";
  return valid_utf8(text);
}

std::string refused_text(const core::Event& event, const AddressWidths& widths) {
  std::string text =
      event.address.to_string(widths) + " refused to " + peer_text(event.client) + ": ";
  if (event.owner.id) return text + "it belongs to " + peer_text(event.owner);
  return text + "it is the router's own";
}

// How the next hop was found: the name in JSON and the explanation.
constexpr std::array kBys{
    core::Label<By>{By::kTable, "table", "it has announced the address"},
    core::Label<By>{By::kStatic, "static", "a static route matches"},
    core::Label<By>{By::kSystem, "system", "it is the router of that system"},
    core::Label<By>{By::kUp, "up", "unknown destinations are sent up"},
    core::Label<By>{By::kNone, "none", ""},
};
static_assert(core::complete(kBys, By::kNone));

// "Tims(1/1) robot1"
std::string router_text(const core::Peer& peer) {
  std::string text = valid_utf8(peer.name.view());
  if (!peer.endpoint.empty()) text += " (" + valid_utf8(peer.endpoint.view()) + ")";
  return text;
}

std::optional<std::string> text_of(const link::NetAddress& address) {
  return address ? std::optional(address.to_string()) : std::nullopt;
}

json::array texts_of(const auto& addresses) {
  json::array texts;
  for (const link::NetAddress& address : addresses) texts.emplace_back(address.to_string());
  return texts;
}

// --- Prometheus page

// A label value ends at the quote; the router's name is the only text that may contain one.
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

// All metrics of these reports, one sample per report. `for_each` calls a function for each
// report.
template <typename Report, typename ForEach, typename LabelsOf>
void add_reports(MetricsPage& page, ForEach for_each, LabelsOf labels_of) {
  for_each_metric<Report>([&](const Metric& metric, auto get) {
    page.family(metric.name, metric.type, metric.help);
    for_each([&](const Report& report) { page.sample(get(report), labels_of(report)); });
  });
}

void add_messages(MetricsPage& page, const core::Router& router) {
  const auto reports = core::report_counts(router);
  add_reports<core::CountReport>(
      page, [&](auto sample) { std::ranges::for_each(reports, sample); },
      [](const core::CountReport& report) -> Labels {
        return {{"port", std::string(core::name(report.port))},
                {"class", std::to_string(report.message_class)},
                {"outcome", std::string(core::name(report.outcome))}};
      });
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

void add_mailboxes(MetricsPage& page, const shm::Counters& counts) {
  page.family("tims_mailbox_messages_total", "counter",
              "Messages to mailboxes in shared memory, from all senders, by outcome.");
  for_each_field<shm::Counters>([&](const auto& field) {
    page.sample(std::invoke(field.get, counts), {{"outcome", std::string(field.name)}});
  });
}

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
  add_reports<PortUse>(
      page, [&](auto sample) { std::ranges::for_each(uses, sample); },
      [](const PortUse& use) -> Labels {
        return {{"port", std::string(core::name(use.port))}};
      });
}

// Sorted by the other router's name: there are few, and their order rarely changes.
void add_links(MetricsPage& page, const AdminSource& source, Time now) {
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

void add_process(MetricsPage& page, const ProcessReport& process,
                 const core::StatusReport& status) {
  add_reports<StatusView>(
      page,
      [&](auto sample) {
        sample(StatusView{status, process});
      },
      [](const StatusView&) { return Labels(); });
  page.family("tims_router_info", "gauge", "Always 1; labels identify this router.");
  page.sample(1, {{"name", process.name},
                  {"address", status.address.to_string(status.widths)},
                  {"version", process.version}});
}

}  // namespace

// --- texts

std::string epoch_text(std::uint64_t epoch) { return fmt::format("{:016x}", epoch); }

std::string via_text(const core::Peer& owner) {
  return owner.port == core::PortKind::kLink ? valid_utf8(owner.name.view())
                                             : std::string(core::name(owner.port));
}

std::string event_text(const core::Event& event, const AddressWidths& widths) {
  using core::EventKind;
  const std::string address = event.address.to_string(widths);
  const std::string client = peer_text(event.client);
  const std::string reason(core::sentence(event.reason));
  switch (event.kind) {
    case EventKind::kClientCame:
      return client + " connected";
    case EventKind::kRegistered:
      return address + " registered by " + client;
    case EventKind::kWithdrawn:
      return address + " withdrawn by " + client;
    case EventKind::kAddressRefused:
      if (event.client.port == core::PortKind::kLink)
        return address + " announced by " + router_text(event.client) +
               " is refused: the [[link]] it arrived on is for another system";
      return refused_text(event, widths);
    case EventKind::kMailboxLimit:
      if (event.client.port == core::PortKind::kLink)
        return router_text(event.client) +
               " announces more mailboxes than its [[link]] allows "
               "(link.mailboxes): " +
               address + " and following ones are refused";
      return address + " refused to " + client + ": limits.mailboxes_per_client";
    case EventKind::kDeleteRefused:
      return client + " may not delete " + address + ": it belongs to " + peer_text(event.owner);
    case EventKind::kClientRefused:
      return client + " was refused: " + reason;
    case EventKind::kClientWent:
      return client + " disconnected" + (reason.empty() ? "" : ": ") + reason;
    case EventKind::kLinkUp:
      return "link to " + router_text(event.client) + " is up";
    case EventKind::kLinkDown:
      return "link to " + router_text(event.client) + " is down: " + reason;
    case EventKind::kLinkRefused:
      return "link with " + router_text(event.client) +
             " refused: " + valid_utf8(event.text.view());
    case EventKind::kLinkPath:
      return "link to " + router_text(event.client) + " changed from " +
             valid_utf8(event.text.view());
    case EventKind::kUplinkChanged:
      return event.client.id ? "unknown destinations are sent up to " + router_text(event.client)
                             : std::string("there is no super router now");
    case EventKind::kDuplicateAddress:
      return address + " of " + router_text(event.client) + " is not used: " +
             (event.owner.id ? router_text(event.owner) : std::string("this router")) +
             " has it already";
    case EventKind::kDuplicateRouter:
      return address + " is both " + router_text(event.client) + " and " +
             router_text(event.owner) + ": change the system or id of one of them";
    case EventKind::kLoop:
      return "messages to " + address + " are in a loop: they come from " +
             router_text(event.client) + " and would go on to " + router_text(event.owner);
    case EventKind::kWatchdogClosed:
    case EventKind::kProtocolError:
      return client + " was disconnected: " + reason;
    default:
      return std::string(core::sentence(event.kind));
  }
}

// --- routes

json::object to_json(const core::RouteReport& report, Address to, const AddressWidths& widths) {
  using Verdict = core::RouteReport::Verdict;
  json::object out{{"address", to_json(AddressView{to, widths})},
                   {"not_available", report.not_available}};
  switch (report.verdict) {
    case Verdict::kDeliver:
      out["verdict"] = "deliver";
      out["reason"] = "registered by " + peer_text(report.mailbox->owner);
      out["via"] = via_text(report.mailbox->owner);
      out["owner"] = to_json(report.mailbox->owner);
      out["age_s"] = base::seconds(report.mailbox->age);
      break;
    case Verdict::kForward:
      out["verdict"] = "forward";
      out["via"] = via_text(report.link);
      out["by"] = core::label(kBys, report.by).name;
      out["next_router"] = to_json(AddressView{report.next, widths});
      out["reason"] = "goes to " + valid_utf8(report.link.name.view()) + ": " +
                      std::string(core::label(kBys, report.by).sentence);
      if (report.mailbox) {
        out["lives_at"] = to_json(AddressView{report.mailbox->origin->router, widths});
        out["hops"] = report.mailbox->origin->hops;
        out["age_s"] = base::seconds(report.mailbox->age);
      }
      break;
    case Verdict::kNoRoute:
      out["verdict"] = "no_route";
      out["outcome"] = core::name(report.why_not);
      out["reason"] = core::sentence(report.why_not);
      break;
    case Verdict::kSelf:
      out["verdict"] = "self";
      out["reason"] = "it is the router's own address";
      break;
  }
  return out;
}

// --- links

json::array Fields<PathView>::targets(const PathView& v) { return texts_of(v.path.targets); }

std::optional<std::string> Fields<PathView>::peer_address(const PathView& v) {
  return text_of(v.path.address);
}

json::array Fields<LinkView>::paths(const LinkView& v) {
  json::array paths;
  for (const link::Path& path : v.link.paths().all())
    paths.push_back(to_json(PathView{v.links, v.link.paths(), path, v.now}));
  return paths;
}

// The current address, or else the first candidate.
std::optional<std::string> Fields<LinkView>::peer_address(const LinkView& v) {
  if (v.link.address()) return text_of(v.link.address());
  const std::vector<link::NetAddress> places = v.link.paths().to_call(true);
  return places.empty() ? std::nullopt : text_of(places.front());
}

json::array Fields<LinkView>::queue_bytes(const LinkView& v) {
  json::array queue;
  for (std::size_t lane = 0; lane < link::kLanes; ++lane)
    queue.push_back(v.session().queued_bytes(lane));
  return queue;
}

json::array Fields<AnnouncementView>::udp(const AnnouncementView& v) {
  return texts_of(v.announcement.udp);
}

bool Fields<AnnouncementView>::linked(const AnnouncementView& v) {
  bool linked = false;
  v.links.for_each([&](const link::Link& link) {
    if (link.is_up() && link.peer().epoch == v.announcement.who.epoch) linked = true;
  });
  return linked;
}

// --- metrics

std::string metrics_text(const AdminSource& source, Time now) {
  MetricsPage page;
  add_messages(page, source.router());
  add_drops_and_events(page, source.router());
  add_mailboxes(page, source.mailbox_counts());
  add_clients(page, source);
  add_links(page, source, now);
  add_process(page, source.process(now), core::report_status(source.router(), now));
  return page.take();
}

}  // namespace tims::io
