#include "router/io/report_json.h"

#include <ctime>

#include <fmt/format.h>

namespace tims::io {

namespace {

namespace json = boost::json;

double seconds(Duration d) { return std::chrono::duration<double>(d).count(); }

json::value known(std::uint32_t number) {
  return number == 0 ? json::value() : json::value(number);
}
json::value known(const std::optional<UdpReport>& socket) {
  if (!socket) return {};
  return {{"asked_buffer_bytes", socket->asked_buffer_bytes},
          {"receive_buffer_bytes", socket->receive_buffer_bytes},
          {"send_buffer_bytes", socket->send_buffer_bytes},
          {"dropped_by_kernel", socket->dropped_by_kernel}};
}
json::value known(std::string_view text) {
  return text.empty() ? json::value() : json::value(as_utf8(text));
}

std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  std::size_t length = 0;
  if (byte(0) < 0x80)
    length = 1;
  else if (byte(0) >> 5 == 0x06 && byte(0) >= 0xC2)
    length = 2;
  else if (byte(0) >> 4 == 0x0E)
    length = 3;
  else if (byte(0) >> 3 == 0x1E && byte(0) <= 0xF4)
    length = 4;
  if (length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if (byte(i) >> 6 != 0x02) return 0;
  // Surrogates, forms that are too long, and what lies beyond Unicode.
  if (length == 3 && ((byte(0) == 0xE0 && byte(1) < 0xA0) || (byte(0) == 0xED && byte(1) > 0x9F)))
    return 0;
  if (length == 4 && ((byte(0) == 0xF0 && byte(1) < 0x90) || (byte(0) == 0xF4 && byte(1) > 0x8F)))
    return 0;
  return length;
}

std::string party_text(const core::Party& party) {
  std::string text(party.name.view());
  if (text.empty())
    text = party.peer.empty() ? "client " + std::to_string(party.id.value)
                              : std::string(party.peer.view());
  if (party.pid != 0) text += " (pid " + std::to_string(party.pid) + ")";
  return as_utf8(text);
}

std::string refused_text(const core::Event& event, const AddressWidths& widths) {
  std::string text =
      event.address.to_string(widths) + " refused to " + party_text(event.client) + ": ";
  if (event.owner.id) return text + "it belongs to " + party_text(event.owner);
  return text + "it is the router's own";
}

using By = core::Router::Way::By;

std::string_view by_text(By by) {
  switch (by) {
    case By::kTable:
      return "table";
    case By::kStatic:
      return "static";
    case By::kSystem:
      return "system";
    case By::kUp:
      return "up";
    case By::kNone:
      break;
  }
  return "none";
}

std::string why_text(By by) {
  switch (by) {
    case By::kTable:
      return "it has announced the address";
    case By::kStatic:
      return "a static route says so";
    case By::kSystem:
      return "it is the router of that system";
    case By::kUp:
      return "what is not known here goes up";
    case By::kNone:
      break;
  }
  return {};
}

// "Tims(1/1) robot1"
std::string router_text(const core::Party& party) {
  std::string text = as_utf8(party.name.view());
  if (!party.peer.empty()) text += " (" + as_utf8(party.peer.view()) + ")";
  return text;
}

}  // namespace

std::string rfc3339(WallTime time) {
  const auto whole = std::chrono::floor<std::chrono::seconds>(time);
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(time - whole).count();
  const std::time_t seconds_since = whole.time_since_epoch().count();
  std::tm fields{};
  ::gmtime_r(&seconds_since, &fields);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:06}Z", fields.tm_year + 1900,
                     fields.tm_mon + 1, fields.tm_mday, fields.tm_hour, fields.tm_min,
                     fields.tm_sec, us);
}

std::string as_utf8(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    if (length == 0)
      out += '?';
    else
      out += text.substr(0, length);
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return out;
}

std::string epoch_text(std::uint64_t epoch) { return fmt::format("{:016x}", epoch); }

json::object to_json(Address address, const AddressWidths& widths) {
  return {{"name", address.to_string(widths)}, {"raw", address.to_hex()}};
}

json::object to_json(const core::Party& party) {
  return {{"client", party.id.value},
          {"port", core::name(party.port)},
          {"name", known(party.name.view())},
          {"pid", known(party.pid)},
          {"peer", known(party.peer.view())}};
}

json::object to_json(const core::ClientReport& report) {
  const bool local = report.client.port == core::PortKind::kLocal;
  return {{"id", report.client.id.value},
          {"port", core::name(report.client.port)},
          {"name", known(report.client.name.view())},
          {"pid", known(report.client.pid)},
          {"uid", local ? json::value(report.uid) : json::value()},
          {"peer", known(report.client.peer.view())},
          {"connected_s", seconds(report.connected)},
          {"mailboxes", report.mailboxes},
          {"watched", report.watched},
          {"in_messages", report.in.messages},
          {"in_bytes", report.in.bytes},
          {"out_messages", report.out.messages},
          {"out_bytes", report.out.bytes},
          {"drops", report.dropped.messages},
          {"drop_bytes", report.dropped.bytes}};
}

// What is behind a link goes by the name of the router there.
std::string via_text(const core::Party& owner) {
  return owner.port == core::PortKind::kLink ? as_utf8(owner.name.view())
                                             : std::string(core::name(owner.port));
}

json::object to_json(const core::MailboxReport& report, const AddressWidths& widths) {
  json::object out{{"address", to_json(report.address, widths)},
                   {"via", via_text(report.owner)},
                   {"owner", to_json(report.owner)},
                   {"router", nullptr},
                   {"hops", 0},
                   {"age_s", seconds(report.age)}};
  if (report.origin) {
    out["router"] = to_json(report.origin->router, widths);
    out["hops"] = report.origin->hops;
  }
  return out;
}

json::object to_json(const MailboxCounts& counts) {
  return {{"received", counts.received},
          {"replaced", counts.replaced},
          {"refused", counts.refused},
          {"too_big", counts.too_big},
          {"reclaimed", counts.reclaimed}};
}

void add_fill(json::object& mailbox, const MailboxFill& fill) {
  mailbox["slots"] = fill.slots;
  mailbox["message_max_bytes"] = fill.message_max;
  mailbox["waiting"] = fill.waiting;
  for (const auto& [name, count] : to_json(fill.counts)) mailbox[name] = count;
  mailbox["asleep"] = fill.asleep;
}

json::object to_json(const core::RouteReport& report, Address to, const AddressWidths& widths) {
  using Verdict = core::RouteReport::Verdict;
  json::object out{{"address", to_json(to, widths)}, {"not_available", report.not_available}};
  switch (report.verdict) {
    case Verdict::kDeliver:
      out["verdict"] = "deliver";
      out["reason"] = "registered by " + party_text(report.mailbox->owner);
      out["via"] = via_text(report.mailbox->owner);
      out["owner"] = to_json(report.mailbox->owner);
      out["age_s"] = seconds(report.mailbox->age);
      break;
    case Verdict::kForward:
      out["verdict"] = "forward";
      out["via"] = via_text(report.link);
      out["by"] = by_text(report.by);
      out["next_router"] = to_json(report.next, widths);
      out["reason"] = "goes to " + as_utf8(report.link.name.view()) + ": " + why_text(report.by);
      if (report.mailbox) {
        out["lives_at"] = to_json(report.mailbox->origin->router, widths);
        out["hops"] = report.mailbox->origin->hops;
        out["age_s"] = seconds(report.mailbox->age);
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

json::object to_json(const core::CountReport& report) {
  using core::Outcome;
  const bool dropped = !core::taken(report.outcome) || report.outcome == Outcome::kMailboxReplaced;
  return {{"port", core::name(report.port)},
          {"class", report.message_class},
          {"outcome", core::name(report.outcome)},
          {"meaning", core::sentence(report.outcome)},
          {"dropped", dropped},
          {"messages", report.count.messages},
          {"bytes", report.count.bytes}};
}

std::string event_text(const core::Event& event, const AddressWidths& widths) {
  using core::EventKind;
  const std::string address = event.address.to_string(widths);
  const std::string client = party_text(event.client);
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
               " is not taken: the [[link]] it came over is for another system";
      return refused_text(event, widths);
    case EventKind::kMailboxLimit:
      if (event.client.port == core::PortKind::kLink)
        return router_text(event.client) +
               " announces more mailboxes than its [[link]] may bring "
               "(link.mailboxes): " +
               address + " and what follows are not taken";
      return address + " refused to " + client + ": limits.mailboxes_per_client";
    case EventKind::kDeleteRefused:
      return client + " may not delete " + address + ": it belongs to " + party_text(event.owner);
    case EventKind::kClientRefused:
      return client + " was turned away: " + reason;
    case EventKind::kClientWent:
      return client + " went away" + (reason.empty() ? "" : ": ") + reason;
    case EventKind::kLinkUp:
      return "link to " + router_text(event.client) + " is up";
    case EventKind::kLinkDown:
      return "link to " + router_text(event.client) + " is down: " + reason;
    case EventKind::kLinkRefused:
      return "link with " + router_text(event.client) + " refused: " + as_utf8(event.text.view());
    case EventKind::kLinkPath:
      return "link to " + router_text(event.client) + " goes from " + as_utf8(event.text.view());
    case EventKind::kUplinkChanged:
      return event.client.id ? "what is not known here goes up to " + router_text(event.client)
                             : std::string("there is no super router any more");
    case EventKind::kDuplicateAddress:
      return address + " of " + router_text(event.client) + " is not used: " +
             (event.owner.id ? router_text(event.owner) : std::string("this router")) +
             " has it already";
    case EventKind::kDuplicateRouter:
      return address + " is both " + router_text(event.client) + " and " +
             router_text(event.owner) + ": give one another system or id";
    case EventKind::kLoop:
      return "messages to " + address + " go round in a loop: they come from " +
             router_text(event.client) + " and would go on to " + router_text(event.owner);
    case EventKind::kWatchdogClosed:
    case EventKind::kProtocolError:
      return client + " was disconnected: " + reason;
    default:
      return std::string(core::sentence(event.kind));
  }
}

json::object to_json(const core::Event& event, const Clocks& clocks, const AddressWidths& widths) {
  json::object out{{"seq", event.sequence},
                   {"time", rfc3339(clocks.wall_time(event.at))},
                   {"kind", core::name(event.kind)},
                   {"address", nullptr},
                   {"client", to_json(event.client)},
                   {"owner", nullptr},
                   {"reason", nullptr},
                   {"text", event_text(event, widths)}};
  if (event.address.raw() != 0) out["address"] = to_json(event.address, widths);
  if (event.owner.id) out["owner"] = to_json(event.owner);
  if (event.reason != core::CloseReason::kNone) out["reason"] = core::name(event.reason);
  return out;
}

json::object to_json(const core::StatusReport& report, const ProcessReport& process) {
  const AddressWidths& w = report.widths;
  return {{"name", as_utf8(process.name)},
          {"address", to_json(report.address, report.widths)},
          {"widths", {w.system, w.class_id, w.instance, w.local}},
          {"version", process.version},
          {"pid", process.pid},
          {"epoch", epoch_text(process.epoch)},
          {"uptime_s", seconds(process.uptime)},
          {"clients", report.clients},
          {"mailboxes", report.mailboxes},
          {"messages", report.forwarded.messages},
          {"bytes", report.forwarded.bytes},
          {"drops", report.drops},
          {"drops_last_minute", report.drops_last_minute},
          {"rss_bytes", process.rss_bytes},
          {"table_bytes", report.table_bytes},
          {"longest_turn_s", seconds(process.longest_turn)},
          {"listen",
           {{"unix", known(process.unix_path)},
            {"tcp", known(process.tcp)},
            {"http", known(process.http)},
            {"udp", known(process.udp)}}},
          {"udp", known(process.udp_socket)},
          {"last_event", report.last_event}};
}

}  // namespace tims::io
