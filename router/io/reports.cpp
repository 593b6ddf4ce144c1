#include "router/io/reports.h"

#include <array>
#include <utility>
#include <vector>

#include <boost/json/object.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/text.h"
#include "router/io/event_text.h"

namespace tims::io {
namespace {

namespace json = boost::json;
using base::seconds;
using base::valid_utf8;
using core::name;
using link::name;
using By = core::NextHop::By;

// --- values

// Null when there is none.
json::value text(std::string_view text) {
  return text.empty() ? json::value() : json::value(valid_utf8(text));
}
json::value pid(std::uint32_t pid) { return pid == 0 ? json::value() : json::value(pid); }
json::value text(const link::NetAddress& address) {
  return address ? text(address.to_string()) : json::value();
}
json::array texts(const auto& addresses) {
  json::array texts;
  for (const link::NetAddress& address : addresses) texts.emplace_back(address.to_string());
  return texts;
}
// Null before it happened.
json::value since(Time now, Time then) {
  return then == Time() ? json::value() : json::value(seconds(now - then));
}

// A mailbox behind a link is reported with the name of the router at the other end of the link.
std::string via_text(const core::Peer& owner) {
  return owner.port == core::PortKind::kLink ? valid_utf8(owner.name.view())
                                             : std::string(core::name(owner.port));
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

// --- links

json::value keys_json(const std::optional<KeysReport>& keys) {
  if (!keys) return {};
  return json::object{{"fleet", text(keys->fleet)},
                      {"identity", text(keys->identity)},
                      {"state", keys->state},
                      {"ends", keys->ends},
                      {"list", keys->list},
                      {"revoked", keys->revoked},
                      {"problem", text(keys->problem)}};
}

json::object identity_json(const link::Identity& identity) {
  return {{"name", text(identity.name)},
          {"role", name(identity.role)},
          {"system", identity.system},
          {"id", identity.id},
          {"address", to_json(identity.address(), identity.widths)},
          {"epoch", epoch_text(identity.epoch)}};
}

json::value clock_json(const std::optional<link::ClockOffset::Sample>& clock) {
  if (!clock) return nullptr;
  return {{"offset_s", static_cast<double>(clock->offset) * 1e-9},
          {"uncertainty_s", static_cast<double>(clock->round_trip) * 0.5e-9}};
}

// What reports of routers and of links have in common. Nothing is known of a router that never
// answered.
json::object link_json(const link::Link& link, std::string_view state, Time now) {
  const bool known = link.peer().epoch != 0;
  const bool up = link.is_up();
  json::object out = identity_json(link.peer());
  if (!known)
    for (auto& field : out) field.value() = nullptr;
  out.insert({{"kind", name(link.settings().kind)},
              {"state", state},
              {"via", text(known ? link.peer().name.view() : link.settings().to)},
              {"since_s", seconds(now - link.since())},
              {"to", text(link.settings().to)},
              {"rtt_s", up && link.rtt().known() ? json::value(seconds(link.rtt().smoothed()))
                                                 : json::value()},
              {"clock", clock_json(up ? link.clock() : std::nullopt)}});
  return out;
}

json::object path_json(const link::Links& links, const link::Paths& paths, const link::Path& path,
                       Time now) {
  return {{"path", name(path.kind)},
          {"used", paths.address() && path.kind == paths.kind()},
          {"works", path.works},
          {"trouble", text(links.trouble(path.kind))},
          {"since_s", since(now, path.since)},
          {"peer_address", text(path.address)},
          {"targets", texts(path.targets)},
          {"datagrams_in", path.counters.datagrams_in},
          {"datagrams_out", path.counters.datagrams_out},
          {"wire_bytes_in", path.counters.bytes_in},
          {"wire_bytes_out", path.counters.bytes_out}};
}

// "10 a second, every 2nd, 4096 bytes"; null: not a rule that thins.
json::value thin_text(const policy::RuleText& rule) {
  std::string out;
  const auto add = [&](std::uint32_t limit, std::string_view before, std::string_view after) {
    if (limit != 0) out += fmt::format("{}{}{}{}", out.empty() ? "" : ", ", before, limit, after);
  };
  add(rule.per_second, "", " a second");
  add(rule.every, "one of ", "");
  add(rule.bytes_max, "", " bytes");
  return text(out);
}

// As the question `fault` names them.
json::object faults_json(const link::Faults& faults) {
  return {{"loss", faults.loss},
          {"duplicate", faults.duplicate},
          {"reorder", faults.reorder},
          {"delay_s", seconds(faults.delay)},
          {"jitter_s", seconds(faults.jitter)},
          {"rate", faults.rate},
          {"blackout", faults.blackout}};
}

// The current address, or else the first candidate.
json::value peer_address(const link::Link& link) {
  if (link.address()) return text(link.address());
  const std::vector<link::NetAddress> places = link.paths().to_call(true);
  return places.empty() ? json::value() : text(places.front());
}

}  // namespace

std::string epoch_text(std::uint64_t epoch) { return fmt::format("{:016x}", epoch); }

// --- addresses, clients, mailboxes

json::object to_json(Address address, const AddressWidths& widths) {
  return {{"name", address.to_string(widths)}, {"raw", address.to_hex()}};
}

json::object to_json(const core::Peer& peer) {
  return {{"client", peer.id.value},
          {"port", name(peer.port)},
          {"name", text(peer.name)},
          {"pid", pid(peer.pid)},
          {"peer", text(peer.endpoint)}};
}

json::object to_json(const core::ClientReport& report) {
  const core::Peer& client = report.client;
  return {{"id", client.id.value},
          {"port", name(client.port)},
          {"name", text(client.name)},
          {"pid", pid(client.pid)},
          {"uid", client.port == core::PortKind::kLocal ? json::value(report.uid) : json::value()},
          {"peer", text(client.endpoint)},
          {"connected_s", seconds(report.connected)},
          {"mailboxes", report.mailboxes},
          {"watched", report.watched},
          {"subject", valid_utf8(fmt::format("{}", fmt::join(report.subject.identities, ", ")))},
          {"judged", report.is_judged},
          {"in_messages", report.in.messages},
          {"in_bytes", report.in.bytes},
          {"out_messages", report.out.messages},
          {"out_bytes", report.out.bytes},
          {"drops", report.dropped.messages},
          {"drop_bytes", report.dropped.bytes}};
}

json::object to_json(const core::MailboxReport& report, const AddressWidths& widths) {
  const auto& origin = report.origin;
  return {{"address", to_json(report.address, widths)},
          {"via", via_text(report.owner)},
          {"owner", to_json(report.owner)},
          {"router", origin ? json::value(to_json(origin->router, widths)) : json::value()},
          {"hops", origin ? origin->hops : 0},
          {"age_s", seconds(report.age)}};
}

json::object to_json(const shm::Counters& counts) {
  return {{"received", counts.received},
          {"replaced", counts.replaced},
          {"refused", counts.refused},
          {"too_big", counts.too_big},
          {"reclaimed", counts.reclaimed}};
}

json::object to_json(const MailboxFill& fill) {
  json::object out{
      {"slots", fill.slots}, {"message_max_bytes", fill.message_max}, {"waiting", fill.waiting}};
  for (const auto& [outcome, count] : to_json(fill.counts)) out[outcome] = count;
  out["asleep"] = fill.asleep;
  return out;
}

json::object to_json(const core::RouteReport& report, Address to, const AddressWidths& widths) {
  using Verdict = core::RouteReport::Verdict;
  json::object out{{"address", to_json(to, widths)}, {"not_available", report.not_available}};
  switch (report.verdict) {
    case Verdict::kDeliver:
      out["verdict"] = "deliver";
      out["reason"] = "registered by " + client_text(report.mailbox->owner);
      out["via"] = via_text(report.mailbox->owner);
      out["owner"] = to_json(report.mailbox->owner);
      out["age_s"] = seconds(report.mailbox->age);
      break;
    case Verdict::kForward:
      out["verdict"] = "forward";
      out["via"] = via_text(report.link);
      out["by"] = core::label(kBys, report.by).name;
      out["next_router"] = to_json(report.next, widths);
      out["reason"] = "goes to " + valid_utf8(report.link.name.view()) + ": " +
                      std::string(core::label(kBys, report.by).sentence);
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
    case Verdict::kDenied:
      out["verdict"] = "denied";
      out["outcome"] = core::name(core::Outcome::kDenied);
      out["rule"] = text(report.denied.rule.name);
      out["place"] = text(report.denied.rule.place);
      out["reason"] = valid_utf8(report.denied.rule.title()) + " denies it to " +
                      valid_utf8(report.denied.subject);
      break;
    case Verdict::kSelf:
      out["verdict"] = "self";
      out["reason"] = "it is the router's own address";
      break;
  }
  return out;
}

// --- counters and events

json::object to_json(const core::CountReport& report) {
  return {{"port", name(report.port)},
          {"class", report.message_class},
          {"outcome", name(report.outcome)},
          {"meaning", core::sentence(report.outcome)},
          {"dropped", core::is_drop(report.outcome)},
          {"messages", report.count.messages},
          {"bytes", report.count.bytes}};
}

json::object to_json(const core::Event& event, const Clocks& clocks, const AddressWidths& widths) {
  return {{"seq", event.sequence},
          {"time", base::rfc3339(clocks.wall_time(event.at))},
          {"kind", name(event.kind)},
          {"address",
           event.address.raw() != 0 ? json::value(to_json(event.address, widths)) : json::value()},
          {"client", to_json(event.client)},
          {"owner", event.owner.id ? json::value(to_json(event.owner)) : json::value()},
          {"reason", event.reason == core::CloseReason::kNone ? json::value()
                                                              : json::value(name(event.reason))},
          {"text", valid_utf8(event_text(event, widths))}};
}

// --- the policy

json::object to_json(const core::RuleReport& report) {
  const policy::RuleText& rule = report.rule;
  const policy::Hits& hits = report.hits;
  return {{"number", report.number},
          {"name", valid_utf8(rule.name)},
          {"place", text(rule.place)},
          {"from", valid_utf8(rule.from)},
          {"to", valid_utf8(rule.to)},
          {"types", valid_utf8(rule.types)},
          {"priority_max", rule.priority_max},
          {"rate_bytes_per_s", rule.rate == 0 ? json::value() : json::value(rule.rate)},
          {"then", rule.then},
          {"thin", thin_text(rule)},
          {"messages", hits.messages},
          {"bytes", hits.bytes},
          {"denied", hits.denied},
          {"over_rate", hits.over_rate},
          {"lowered", hits.lowered},
          {"thinned", hits.thinned}};
}

json::object to_json(const core::VerdictReport& report) {
  return {{"verdict", name(report.action)},
          {"priority", report.priority},
          {"rule", valid_utf8(report.rule.name)},
          {"place", text(report.rule.place)},
          {"subject", valid_utf8(report.subject)}};
}

// --- streams and their newest values, driving leases

json::object to_json(const core::NewestValues::Value& value, const AddressWidths& widths,
                     Time now) {
  return {{"address", to_json(value.header.src, widths)},
          {"stream", name(value.kind)},
          {"type", value.header.type},
          {"age_s", seconds(now - value.at)},
          {"bytes", value.header.body_size()},
          {"samples", value.samples}};
}

json::object to_json(const core::NewestValues::Counts& counts) {
  return {{"values", counts.values},       {"bytes", counts.bytes},
          {"bytes_max", counts.bytes_max}, {"added", counts.added},
          {"replaced", counts.replaced},   {"evicted", counts.evicted},
          {"too_big", counts.too_big}};
}

json::object to_json(const core::StreamReport& report, const AddressWidths& widths) {
  return {{"client", report.client.value},
          {"from", to_json(report.stream.src, widths)},
          {"to", to_json(report.stream.dest, widths)},
          {"type", report.stream.type},
          {"samples", report.stream.samples},
          {"dropped", report.stream.dropped},
          {"waiting", report.stream.waiting}};
}

json::object to_json(const core::DrivingLease& lease, const AddressWidths& widths, Time now) {
  const auto address = [&](Address a) {
    return a.raw() == 0 ? json::value() : json::value(to_json(a, widths));
  };
  return {{"robot", lease.robot},
          {"holder", text(lease.holder)},
          {"client", to_json(lease.client)},
          {"mailbox", address(lease.mailbox)},
          {"stick", address(lease.stick)},
          {"age_s", seconds(now - lease.since)},
          {"left_s", seconds(lease.until - now)}};
}

// --- the router and its process

json::object to_json(const link::Handshakes::Counters& handshakes) {
  return {{"in_progress", handshakes.in_progress},
          {"accepted", handshakes.accepted},
          {"answered", handshakes.answered},
          {"given_up", handshakes.given_up},
          {"turned_away", handshakes.turned_away}};
}

json::object to_json(const core::StatusReport& router, const ProcessReport& process) {
  const AddressWidths& w = router.widths;
  json::value udp;
  if (const auto& socket = process.udp_socket)
    udp = {{"asked_buffer_bytes", socket->asked_buffer_bytes},
           {"receive_buffer_bytes", socket->receive_buffer_bytes},
           {"send_buffer_bytes", socket->send_buffer_bytes},
           {"dropped_by_kernel", socket->dropped_by_kernel},
           {"strange", socket->strange},
           {"unknown_token", socket->unknown_token},
           {"refused", socket->refused},
           {"handshakes", to_json(socket->handshakes)}};
  return {{"name", valid_utf8(process.name)},
          {"address", to_json(router.address, w)},
          {"widths", json::array{w.system, w.class_id, w.instance, w.local}},
          {"version", valid_utf8(process.version)},
          {"pid", process.pid},
          {"epoch", epoch_text(process.epoch)},
          {"uptime_s", seconds(process.uptime)},
          {"clients", router.clients},
          {"mailboxes", router.mailboxes},
          {"messages", router.forwarded.messages},
          {"bytes", router.forwarded.bytes},
          {"drops", router.drops},
          {"drops_last_minute", router.drops_last_minute},
          {"rss_bytes", process.rss_bytes},
          {"table_bytes", router.table_bytes},
          {"longest_turn_s", seconds(process.longest_turn)},
          {"listen", json::object{{"unix", text(process.unix_path)},
                                  {"tcp", text(process.tcp)},
                                  {"http", text(process.http)},
                                  {"udp", text(process.udp)}}},
          {"udp", std::move(udp)},
          {"security",
           json::object{{"insecure", process.insecure},
                        {"exposed", json::array(process.exposed.begin(), process.exposed.end())},
                        {"cautions", json::array(process.cautions.begin(), process.cautions.end())},
                        {"keys", keys_json(process.keys)}}},
          {"http", json::object{{"console", text(process.console)},
                                {"refused_host", process.http_refused.host},
                                {"refused_origin", process.http_refused.origin},
                                {"refused_cross_site", process.http_refused.cross_site}}},
          {"last_event", router.last_event}};
}

json::object to_json(const DdsReport& report) {
  return {{"state", valid_utf8(report.state)},
          {"trouble", text(report.trouble)},
          {"address", text(report.address)},
          {"samples_in", report.samples_in},
          {"samples_out", report.samples_out},
          {"datagrams_in", report.datagrams_in},
          {"datagrams_out", report.datagrams_out},
          {"strange", report.strange},
          {"refused", report.refused},
          {"unmatched", report.unmatched},
          {"waiting_bytes", report.waiting_bytes}};
}

// --- routers and links

json::object to_json(const link::Identity& self, const ProcessReport& process) {
  json::object out = identity_json(self);
  out.insert({{"kind", "self"},
              {"state", "up"},
              {"via", nullptr},
              {"since_s", seconds(process.uptime)},
              {"version", valid_utf8(process.version)}});
  return out;
}

json::object to_json(const link::Link& link, Time now) {
  return link_json(link, link.is_up() ? "up" : "down", now);
}

json::object to_json(const core::MissingRouter& missing, const AddressWidths& widths, Time now) {
  const json::value via = text(missing.via);
  const auto fields = missing.router.fields(widths);
  return {{"name", missing.router == missing.behind ? via : json::value()},
          {"role", nullptr},
          {"system", fields.system},
          {"id", fields.instance},
          {"address", to_json(missing.router, widths)},
          {"epoch", nullptr},
          {"kind", "missing"},
          {"state", "down"},
          {"via", via},
          {"behind", to_json(missing.behind, widths)},
          {"since_s", seconds(now - missing.since)},
          {"rtt_s", nullptr},
          {"clock", nullptr}};
}

json::object compression_json(const link::Link& link) {
  const link::PackingCounters& counters = link.packing();
  const auto method = link.is_up() ? link.packs_with() : std::nullopt;
  return {
      {"method", method ? json::value(compression::name(*method)) : json::value()},
      {"ratio", counters.bytes_after == 0 ? json::value()
                                          : json::value(static_cast<double>(counters.bytes_before) /
                                                        static_cast<double>(counters.bytes_after))},
      {"cpu_s", seconds(counters.spent)},
      {"packed", counters.packed},
      {"reused", counters.reused},
      {"bytes_before", counters.bytes_before},
      {"bytes_after", counters.bytes_after},
      {"incompressible", counters.incompressible},
      {"unpacked", counters.unpacked},
      {"bytes_unpacked", counters.bytes_unpacked},
      {"passed", counters.passed},
      {"broken", counters.broken}};
}

json::object to_json(const link::Links& links, const link::Link& link, const core::Router& router,
                     const link::Faults* faults, Time now) {
  const link::LinkSession& session = link.session();
  const auto& counters = session.counters();
  const core::Client none;
  const core::Client* known = router.client(link.client());
  const core::Client& client = known == nullptr ? none : *known;
  json::array paths;
  for (const link::Path& path : link.paths().all())
    paths.push_back(path_json(links, link.paths(), path, now));
  json::array queue;
  for (std::size_t lane = 0; lane < link::kLanes; ++lane)
    queue.push_back(session.queued_bytes(lane));
  const json::array class_bytes(counters.lane_bytes_out.begin(), counters.lane_bytes_out.end());
  json::object out = link_json(link, name(link.state()), now);
  out.insert(
      {{"peer", link.peer().epoch != 0 ? text(link.peer().name) : json::value()},
       {"connects", link.settings().connects},
       {"secure", link.is_up() ? link.keys().are_used() : link.settings().secure},
       {"suite", text(link.keys().suite())},
       {"certificate", text(link.certificate().name)},
       {"keys_since_s",
        link.keys().are_used() ? json::value(seconds(now - link.keys().since())) : json::value()},
       {"active", &link == links.uplink()},
       {"path", name(link.paths().kind())},
       {"path_why", text(link.paths().why())},
       {"path_since_s",
        link.is_up() ? json::value(seconds(now - link.paths().since())) : json::value()},
       {"paths", std::move(paths)},
       {"peer_address", peer_address(link)},
       {"refusal", text(link.refusal())},
       {"heard_s", since(now, link.last_received())},
       {"keep_alive_s", seconds(link.settings().keep_alive)},
       {"loss_in", session.loss_permille() / 1000.0},
       {"loss_out", link.their_loss_permille() / 1000.0},
       {"mtu_bytes", session.mtu()},
       {"window_bytes", session.congestion().window()},
       {"in_flight_bytes", session.in_flight()},
       {"queue_delay_s", seconds(session.congestion().queue_delay())},
       {"rate_limit_bytes_per_s", link.settings().session.rate},
       {"faults", faults == nullptr ? json::value() : json::value(faults_json(*faults))},
       {"queue_bytes", std::move(queue)},
       {"packets_in", counters.packets_in},
       {"packets_out", counters.packets_out},
       {"packets_lost", counters.packets_lost},
       {"packets_replayed", counters.packets_replayed},
       {"packets_forged", counters.packets_forged},
       {"packets_old_key", counters.packets_old_key},
       {"sample_repeats", counters.sample_repeats},
       {"samples_incomplete", session.samples_in().incomplete()},
       {"samples_overtaken", session.samples_in().overtaken()},
       {"wire_bytes_in", counters.bytes_in},
       {"wire_bytes_out", counters.bytes_out},
       {"class_bytes_out", class_bytes},
       {"compression", compression_json(link)},
       {"mailboxes", link.mailboxes()},
       {"mailboxes_refused", link.mailboxes_refused()},
       {"in_messages", client.in.messages},
       {"in_bytes", client.in.bytes},
       {"out_messages", client.out.messages},
       {"out_bytes", client.out.bytes},
       {"drops", client.dropped.messages}});
  return out;
}

json::object to_json(const link::Links& links, const link::Announcement& announcement) {
  bool linked = false;
  links.for_each([&](const link::Link& link) {
    linked = linked || (link.is_up() && link.peer().epoch == announcement.identity.epoch);
  });
  json::object out = identity_json(announcement.identity);
  out.insert({{"udp", texts(announcement.udp)},
              {"dds", announcement.dds.to_string()},
              {"linked", linked}});
  return out;
}

}  // namespace tims::io
