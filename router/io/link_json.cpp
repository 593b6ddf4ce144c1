#include "router/io/link_json.h"

namespace tims::io {
namespace {

namespace json = boost::json;

double seconds(Duration d) { return std::chrono::duration<double>(d).count(); }

json::value text_or_null(std::string_view text) {
  return text.empty() ? json::value() : json::value(as_utf8(text));
}

json::value where_or_null(const link::NetAddress& address) {
  return address ? json::value(address.to_string()) : json::value();
}

json::object identity_json(const link::Identity& who) {
  return {{"name", text_or_null(who.name.view())},
          {"role", core::name(who.role)},
          {"system", who.system},
          {"id", who.id},
          {"address", to_json(who.address(), who.widths)},
          {"epoch", epoch_text(who.epoch)}};
}

json::object clock_json(const link::ClockOffset::Sample& sample) {
  return {{"offset_s", static_cast<double>(sample.offset) * 1e-9},
          {"uncertainty_s", static_cast<double>(sample.round_trip) * 0.5e-9}};
}

json::array paths_json(const link::Links& links, const link::Paths& paths, Time now) {
  json::array out;
  for (const link::Path& path : paths.all()) {
    json::array targets;
    for (const link::NetAddress& target : path.targets) targets.emplace_back(target.to_string());
    out.push_back(json::object{
        {"path", link::name(path.kind)},
        {"used", paths.address() && path.kind == paths.kind()},
        {"works", path.works},
        {"trouble", text_or_null(links.trouble(path.kind))},
        {"since_s", path.since == Time() ? json::value() : json::value(seconds(now - path.since))},
        {"peer_address", where_or_null(path.address)},
        {"targets", std::move(targets)},
        {"datagrams_in", path.counters.datagrams_in},
        {"datagrams_out", path.counters.datagrams_out},
        {"wire_bytes_in", path.counters.bytes_in},
        {"wire_bytes_out", path.counters.bytes_out}});
  }
  return out;
}

// Drops by reason, of what was handed to this link: counted in the client.
json::array queue_json(const link::Session& session) {
  json::array queue;
  for (std::size_t lane = 0; lane < link::kLanes; ++lane)
    queue.push_back(session.queued_bytes(lane));
  return queue;
}

}  // namespace

json::object self_json(const link::Identity& self, const ProcessReport& process) {
  json::object out = identity_json(self);
  out["kind"] = "self";
  out["state"] = "up";
  out["via"] = nullptr;
  out["since_s"] = seconds(process.uptime);
  out["version"] = process.version;
  return out;
}

json::object router_json(const link::Link& link, Time now) {
  const bool known = link.peer().epoch != 0;
  json::object out = known ? identity_json(link.peer()) : json::object();
  if (!known) {
    for (const char* field : {"name", "role", "system", "id", "address", "epoch"})
      out[field] = nullptr;
  }
  out["kind"] = core::name(link.settings().kind);
  out["state"] = link.is_up() ? "up" : "down";
  out["via"] = text_or_null(known ? link.peer().name.view() : link.settings().to);
  out["since_s"] = seconds(now - link.since());
  out["to"] = text_or_null(link.settings().to);
  out["rtt_s"] = link.is_up() && link.rtt().known() ? json::value(seconds(link.rtt().smoothed()))
                                                    : json::value();
  out["clock"] = nullptr;
  if (const auto clock = link.clock(); clock && link.is_up()) out["clock"] = clock_json(*clock);
  return out;
}

json::object missing_json(const core::MissingRouter& missing, const AddressWidths& widths,
                          Time now) {
  const auto fields = missing.router.fields(widths);
  return {
      {"name", missing.router == missing.behind ? text_or_null(missing.via.view()) : json::value()},
      {"role", nullptr},
      {"system", fields.system},
      {"id", fields.instance},
      {"address", to_json(missing.router, widths)},
      {"epoch", nullptr},
      {"kind", "missing"},
      {"state", "down"},
      {"via", text_or_null(missing.via.view())},
      {"behind", to_json(missing.behind, widths)},
      {"since_s", seconds(now - missing.since)},
      {"rtt_s", nullptr},
      {"clock", nullptr}};
}

json::object link_json(const link::Links& links, const link::Link& link, const core::Router& router,
                       Time now) {
  const link::Session& session = link.session();
  const link::SessionCounters& counters = session.counters();
  const core::Client* client = router.client(link.client());
  json::object out = router_json(link, now);
  out["peer"] = out["name"];
  out["state"] = link::name(link.state());
  out["kind"] = core::name(link.settings().kind);
  out["connects"] = link.settings().connects;
  out["active"] = &link == links.uplink();
  const link::Paths& paths = link.paths();
  const std::vector<link::NetAddress> places = paths.to_call(true);
  out["path"] = link::name(paths.kind());
  out["path_why"] = text_or_null(paths.why());
  out["path_since_s"] = link.is_up() ? json::value(seconds(now - paths.since())) : json::value();
  out["paths"] = paths_json(links, paths, now);
  out["peer_address"] = where_or_null(link.address()   ? link.address()
                                      : places.empty() ? link::NetAddress()
                                                       : places.front());
  out["refusal"] = text_or_null(link.refusal().view());
  out["heard_s"] =
      link.heard() == Time() ? json::value() : json::value(seconds(now - link.heard()));
  out["keep_alive_s"] = seconds(link.settings().keep_alive);
  out["loss_in"] = session.loss_permille() / 1000.0;
  out["loss_out"] = link.their_loss_permille() / 1000.0;
  out["mtu_bytes"] = session.mtu();
  out["window_bytes"] = session.congestion().window();
  out["in_flight_bytes"] = session.in_flight();
  out["queue_delay_s"] = seconds(session.congestion().queue_delay());
  out["rate_limit_bytes_per_s"] = link.settings().session.rate;
  out["queue_bytes"] = queue_json(session);
  out["packets_in"] = counters.packets_in;
  out["packets_out"] = counters.packets_out;
  out["packets_lost"] = counters.packets_lost;
  out["packets_duplicate"] = counters.packets_duplicate;
  out["wire_bytes_in"] = counters.bytes_in;
  out["wire_bytes_out"] = counters.bytes_out;
  out["mailboxes"] = link.mailboxes();
  out["mailboxes_refused"] = link.mailboxes_refused();
  out["in_messages"] = client == nullptr ? 0 : client->in.messages;
  out["in_bytes"] = client == nullptr ? 0 : client->in.bytes;
  out["out_messages"] = client == nullptr ? 0 : client->out.messages;
  out["out_bytes"] = client == nullptr ? 0 : client->out.bytes;
  out["drops"] = client == nullptr ? 0 : client->dropped.messages;
  return out;
}

json::object announcement_json(const link::Links& links, const link::Announcement& announcement) {
  json::object out = identity_json(announcement.who);
  json::array udp;
  for (const link::NetAddress& address : announcement.udp) udp.emplace_back(address.to_string());
  out["udp"] = std::move(udp);
  out["dds"] = announcement.dds.to_string();
  out["linked"] = false;
  links.for_each([&](const link::Link& link) {
    if (link.is_up() && link.peer().epoch == announcement.who.epoch) out["linked"] = true;
  });
  return out;
}

json::object dds_json(const DdsReport& dds) {
  return {{"state", dds.state},
          {"trouble", text_or_null(dds.trouble)},
          {"address", text_or_null(dds.address)},
          {"samples_in", dds.samples_in},
          {"samples_out", dds.samples_out},
          {"datagrams_in", dds.datagrams_in},
          {"datagrams_out", dds.datagrams_out},
          {"strange", dds.strange},
          {"refused", dds.refused},
          {"unmatched", dds.unmatched},
          {"waiting_bytes", dds.waiting_bytes}};
}

}  // namespace tims::io
