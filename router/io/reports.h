// The reports that the admin protocol (ADMIN.md) sends. Their contents come from the core's
// reports, from values that only the process and its ports have (AdminSource and the structs
// above it), and from views that combine an item with the context needed to print it. The fields
// of each report are listed once, together with the metrics that some of them are exported as.
// Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <fmt/format.h>

#include "base/measure.h"
#include "router/config/config.h"
#include "router/config/load.h"
#include "router/core/report.h"
#include "router/core/router.h"
#include "router/io/fields.h"
#include "router/link/fault_injection.h"
#include "router/link/links.h"
#include "shm/receiver.h"
#include "tims/time.h"

namespace tims::io {

// --- sources of the answers

// The socket shared by all links.
struct UdpReport {
  std::uint32_t asked_buffer_bytes = 0;  // requested from the system, in each direction
  std::uint32_t receive_buffer_bytes = 0;
  std::uint32_t send_buffer_bytes = 0;
  std::uint64_t dropped_by_kernel = 0;  // datagrams dropped because the buffer was full
};

// The engine that serves all DDS paths.
struct DdsReport {
  std::string state{};    // "up", "starting"
  std::string trouble{};  // the last error or warning it reported
  std::string address{};
  std::uint64_t samples_in = 0;
  std::uint64_t samples_out = 0;
  std::uint64_t datagrams_in = 0;
  std::uint64_t datagrams_out = 0;
  std::uint64_t strange = 0;    // samples not sent by a tims router
  std::uint64_t refused = 0;    // datagrams dropped: no room, or no receiver
  std::uint64_t unmatched = 0;  // datagrams whose receiver did not appear
  std::uint64_t waiting_bytes = 0;
};

struct ProcessReport {
  std::string name{};     // router.name
  std::string version{};  // of the program
  std::uint32_t pid = 0;
  std::uint64_t epoch = 0;  // chosen at random at start
  Duration uptime{};
  std::uint64_t rss_bytes = 0;
  Duration longest_turn{};  // of the event loop
  // Listening addresses; empty when the port is not listening.
  std::string unix_path{};
  std::string tcp{};
  std::string http{};
  std::string udp{};
  std::optional<UdpReport> udp_socket{};
};

// State of a mailbox as visible in shared memory.
struct MailboxFill {
  std::uint32_t slots = 0;
  std::uint32_t message_max = 0;  // bytes, header included
  std::uint64_t waiting = 0;
  shm::Counters counts{};
  bool asleep = false;
};

class AdminSource : public core::Interface {
 public:
  [[nodiscard]] virtual const core::Router& router() const = 0;
  [[nodiscard]] virtual ProcessReport process(Time now) const = 0;
  [[nodiscard]] virtual const config::Config& config() const = 0;
  [[nodiscard]] virtual const config::Origins& origins() const = 0;
  // Null when the router has no links.
  [[nodiscard]] virtual const link::Links* links() const { return nullptr; }
  // Empty when this router is not in a fleet.
  [[nodiscard]] virtual std::optional<DdsReport> dds() const { return std::nullopt; }
  // Executes the request; returns false when the link does not exist.
  virtual bool act_on_link(std::string_view, link::Links::Action) { return false; }
  virtual bool inject_faults(std::string_view, const link::Faults&) { return false; }
  virtual void set_static_routes(const std::vector<core::StaticRoute>&) {}
  // `handle` of a local mailbox (core::MailboxReport); empty when its fill level is unknown.
  [[nodiscard]] virtual std::optional<MailboxFill> fill(std::uint32_t handle) const = 0;
  // Sums over all mailboxes, including those that no longer exist.
  [[nodiscard]] virtual shm::Counters mailbox_counts() const = 0;
  [[nodiscard]] virtual std::uint64_t queued_bytes(core::PortKind port,
                                                   std::uint32_t token) const = 0;
};

using base::WallTime;

// Two clocks read at the same moment: events carry monotonic time, users expect wall-clock time.
struct Clocks {
  Time now{};
  WallTime wall{};

  [[nodiscard]] WallTime wall_time(Time at) const { return wall - (now - at); }
};

// --- texts

// 16 hex digits, because JSON numbers do not hold 64 bits in every implementation.
std::string epoch_text(std::uint64_t epoch);
// A mailbox behind a link is reported with the name of the router at the other end of the link.
std::string via_text(const core::Peer& owner);
// One line of text: "Ladar(3/0) registered by laser (pid 811)".
std::string event_text(const core::Event& event, const AddressWidths& widths);

// --- addresses, clients, mailboxes

struct AddressView {
  Address address{};
  AddressWidths widths{};  // the router's widths, used to format names
};
template <>
struct Fields<AddressView> {
  static constexpr std::tuple list{
      Field{"name", [](auto& v) { return v.address.to_string(v.widths); }},
      Field{"raw", [](auto& v) { return v.address.to_hex(); }}};
};

template <>
struct Fields<core::Peer> {
  static constexpr std::tuple list{
      Field{"client", [](auto& p) { return p.id.value; }}, Field{"port", &core::Peer::port},
      Field{"name", [](auto& p) { return unless_empty(p.name.view()); }},
      Field{"pid", [](auto& p) { return unless_empty(p.pid); }},
      Field{"peer", [](auto& p) { return unless_empty(p.endpoint.view()); }}};
};

template <>
struct Fields<core::ClientReport> {
  using Report = core::ClientReport;
  static std::optional<std::uint32_t> uid(const Report& r) {
    return r.client.port == core::PortKind::kLocal ? std::optional(r.uid) : std::nullopt;
  }
  static constexpr std::tuple list{
      Field{"id", [](auto& r) { return r.client.id.value; }},
      Field{"port", [](auto& r) { return r.client.port; }},
      Field{"name", [](auto& r) { return unless_empty(r.client.name.view()); }},
      Field{"pid", [](auto& r) { return unless_empty(r.client.pid); }},
      Field{"uid", uid},
      Field{"peer", [](auto& r) { return unless_empty(r.client.endpoint.view()); }},
      Field{"connected_s", &Report::connected},
      Field{"mailboxes", &Report::mailboxes},
      Field{"watched", &Report::watched},
      Field{"in_messages", [](auto& r) { return r.in.messages; }},
      Field{"in_bytes", [](auto& r) { return r.in.bytes; }},
      Field{"out_messages", [](auto& r) { return r.out.messages; }},
      Field{"out_bytes", [](auto& r) { return r.out.bytes; }},
      Field{"drops", [](auto& r) { return r.dropped.messages; }},
      Field{"drop_bytes", [](auto& r) { return r.dropped.bytes; }}};
};

// Totals of all clients of one port; exported as a metric only.
struct PortUse {
  core::PortKind port{};
  std::size_t clients = 0;
  std::uint64_t queued_bytes = 0;
};
template <>
struct Fields<PortUse> {
  static constexpr std::tuple list{
      Field{"", &PortUse::clients,
            gauge(1, "tims_router_clients", "Clients that are connected, by port.")},
      Field{"", &PortUse::queued_bytes,
            gauge(2, "tims_router_queued_bytes",
                  "Bytes queued in the router for clients that read slowly, by port.")}};
};

struct MailboxView {
  const core::MailboxReport& report;
  const AddressWidths& widths;
};
template <>
struct Fields<MailboxView> {
  static std::optional<AddressView> router(const MailboxView& v) {
    return v.report.origin ? std::optional(AddressView{v.report.origin->router, v.widths})
                           : std::nullopt;
  }
  static constexpr std::tuple list{
      Field{"address",
            [](auto& v) {
              return AddressView{v.report.address, v.widths};
            }},
      Field{"via", [](auto& v) { return via_text(v.report.owner); }},
      Field{"owner", [](auto& v) { return v.report.owner; }},
      Field{"router", router},
      Field{"hops", [](auto& v) { return v.report.origin ? v.report.origin->hops : 0; }},
      Field{"age_s", [](auto& v) { return v.report.age; }}};
};

// Counted by outcome; the field names are also label values of one metric.
template <>
struct Fields<shm::Counters> {
  static constexpr std::tuple list{
      Field{"received", &shm::Counters::received}, Field{"replaced", &shm::Counters::replaced},
      Field{"refused", &shm::Counters::refused}, Field{"too_big", &shm::Counters::too_big},
      Field{"reclaimed", &shm::Counters::reclaimed}};
};

template <>
struct Fields<MailboxFill> {
  static constexpr std::tuple list{
      Field{"slots", &MailboxFill::slots}, Field{"message_max_bytes", &MailboxFill::message_max},
      Field{"waiting", &MailboxFill::waiting}, Field{"", &MailboxFill::counts},
      Field{"asleep", &MailboxFill::asleep}};
};

// The result of routing a message; the set of fields depends on the verdict.
boost::json::object to_json(const core::RouteReport& report, Address to,
                            const AddressWidths& widths);

// --- counters and events

template <>
struct Fields<core::CountReport> {
  using Report = core::CountReport;
  static constexpr std::tuple list{
      Field{"port", &Report::port},
      Field{"class", &Report::message_class},
      Field{"outcome", &Report::outcome},
      Field{"meaning", [](auto& r) { return core::sentence(r.outcome); }},
      Field{"dropped", [](auto& r) { return core::is_drop(r.outcome); }},
      Field{
          "messages", [](auto& r) { return r.count.messages; },
          counter(1, "tims_router_messages_total",
                  "Messages by the port they came through, priority class (0 to 7) and outcome.")},
      Field{"bytes", [](auto& r) { return r.count.bytes; },
            counter(2, "tims_router_message_bytes_total",
                    "Bytes of these messages, headers included.")}};
};

struct EventView {
  const core::Event& event;
  const Clocks& clocks;
  const AddressWidths& widths;
};
template <>
struct Fields<EventView> {
  static std::optional<AddressView> address(const EventView& v) {
    return v.event.address.raw() != 0 ? std::optional(AddressView{v.event.address, v.widths})
                                      : std::nullopt;
  }
  static std::optional<core::Peer> owner(const EventView& v) {
    return v.event.owner.id ? std::optional(v.event.owner) : std::nullopt;
  }
  static constexpr std::tuple list{
      Field{"seq", [](auto& v) { return v.event.sequence; }},
      Field{"time", [](auto& v) { return base::rfc3339(v.clocks.wall_time(v.event.at)); }},
      Field{"kind", [](auto& v) { return v.event.kind; }},
      Field{"address", address},
      Field{"client", [](auto& v) { return v.event.client; }},
      Field{"owner", owner},
      Field{"reason", [](auto& v) { return unless_empty(v.event.reason); }},
      Field{"text", [](auto& v) { return event_text(v.event, v.widths); }}};
};

// --- the router and its process

template <>
struct Fields<UdpReport> {
  static constexpr std::tuple list{Field{"asked_buffer_bytes", &UdpReport::asked_buffer_bytes},
                                   Field{"receive_buffer_bytes", &UdpReport::receive_buffer_bytes},
                                   Field{"send_buffer_bytes", &UdpReport::send_buffer_bytes},
                                   Field{"dropped_by_kernel", &UdpReport::dropped_by_kernel}};
};

template <>
struct Fields<DdsReport> {
  static constexpr std::tuple list{
      Field{"state", &DdsReport::state},
      Field{"trouble", [](auto& r) { return unless_empty(r.trouble); }},
      Field{"address", [](auto& r) { return unless_empty(r.address); }},
      Field{"samples_in", &DdsReport::samples_in},
      Field{"samples_out", &DdsReport::samples_out},
      Field{"datagrams_in", &DdsReport::datagrams_in},
      Field{"datagrams_out", &DdsReport::datagrams_out},
      Field{"strange", &DdsReport::strange},
      Field{"refused", &DdsReport::refused},
      Field{"unmatched", &DdsReport::unmatched},
      Field{"waiting_bytes", &DdsReport::waiting_bytes}};
};

struct ListenView {
  const ProcessReport& process;
};
template <>
struct Fields<ListenView> {
  static constexpr std::tuple list{
      Field{"unix", [](auto& v) { return unless_empty(v.process.unix_path); }},
      Field{"tcp", [](auto& v) { return unless_empty(v.process.tcp); }},
      Field{"http", [](auto& v) { return unless_empty(v.process.http); }},
      Field{"udp", [](auto& v) { return unless_empty(v.process.udp); }}};
};

struct StatusView {
  const core::StatusReport& router;
  const ProcessReport& process;
};
template <>
struct Fields<StatusView> {
  using View = StatusView;
  static boost::json::array widths(const View& v) {
    const AddressWidths& w = v.router.widths;
    return {w.system, w.class_id, w.instance, w.local};
  }
  static constexpr std::tuple list{
      Field{"name", [](auto& v) { return v.process.name; }},
      Field{"address",
            [](auto& v) {
              return AddressView{v.router.address, v.router.widths};
            }},
      Field{"widths", widths},
      Field{"version", [](auto& v) { return v.process.version; }},
      Field{"pid", [](auto& v) { return v.process.pid; }},
      Field{"epoch", [](auto& v) { return epoch_text(v.process.epoch); }},
      Field{"uptime_s", [](auto& v) { return v.process.uptime; },
            gauge(3, "tims_router_uptime_seconds", "Time since the router was started.")},
      Field{"clients", [](auto& v) { return v.router.clients; }},
      Field{"mailboxes", [](auto& v) { return v.router.mailboxes; },
            gauge(1, "tims_router_mailboxes", "Mailboxes that are registered.")},
      Field{"messages", [](auto& v) { return v.router.forwarded.messages; }},
      Field{"bytes", [](auto& v) { return v.router.forwarded.bytes; }},
      Field{"drops", [](auto& v) { return v.router.drops; }},
      Field{"drops_last_minute", [](auto& v) { return v.router.drops_last_minute; }},
      Field{"rss_bytes", [](auto& v) { return v.process.rss_bytes; },
            gauge(5, "process_resident_memory_bytes", "Memory of the router's process.")},
      Field{"table_bytes", [](auto& v) { return v.router.table_bytes; },
            gauge(2, "tims_router_table_bytes", "Memory of the table of mailboxes.")},
      Field{"longest_turn_s", [](auto& v) { return v.process.longest_turn; },
            gauge(4, "tims_router_longest_turn_seconds",
                  "Longest turn of the event loop: so long have others had to wait.")},
      Field{"listen", [](auto& v) { return ListenView{v.process}; }},
      Field{"udp", [](auto& v) { return v.process.udp_socket; }},
      Field{"last_event", [](auto& v) { return v.router.last_event; }}};
};

// --- routers and links

template <>
struct Fields<link::Identity> {
  using Identity = link::Identity;
  static constexpr std::tuple list{
      Field{"name", [](auto& who) { return unless_empty(who.name.view()); }},
      Field{"role", &Identity::role},
      Field{"system", &Identity::system},
      Field{"id", &Identity::id},
      Field{"address",
            [](auto& who) {
              return AddressView{who.address(), who.widths};
            }},
      Field{"epoch", [](auto& who) { return epoch_text(who.epoch); }}};
};

// The router that answers, as an entry of the router list.
struct SelfView {
  const link::Identity& self;
  const ProcessReport& process;
};
template <>
struct Fields<SelfView> {
  static constexpr std::tuple list{Field{"", [](auto& v) { return v.self; }},
                                   Field{"kind", [](auto&) { return "self"; }},
                                   Field{"state", [](auto&) { return "up"; }},
                                   Field{"via", [](auto&) { return nullptr; }},
                                   Field{"since_s", [](auto& v) { return v.process.uptime; }},
                                   Field{"version", [](auto& v) { return v.process.version; }}};
};

// A router that a link announced before the link went down.
struct MissingView {
  const core::MissingRouter& missing;
  const AddressWidths& widths;
  Time now{};
};
template <>
struct Fields<MissingView> {
  using View = MissingView;
  static std::optional<std::string_view> name(const View& v) {
    const bool is_neighbour = v.missing.router == v.missing.behind;
    return is_neighbour ? unless_empty(v.missing.via.view()) : std::nullopt;
  }
  static constexpr std::tuple list{
      Field{"name", name},
      Field{"role", [](auto&) { return nullptr; }},
      Field{"system", [](auto& v) { return v.missing.router.fields(v.widths).system; }},
      Field{"id", [](auto& v) { return v.missing.router.fields(v.widths).instance; }},
      Field{"address",
            [](auto& v) {
              return AddressView{v.missing.router, v.widths};
            }},
      Field{"epoch", [](auto&) { return nullptr; }},
      Field{"kind", [](auto&) { return "missing"; }},
      Field{"state", [](auto&) { return "down"; }},
      Field{"via", [](auto& v) { return unless_empty(v.missing.via.view()); }},
      Field{"behind",
            [](auto& v) {
              return AddressView{v.missing.behind, v.widths};
            }},
      Field{"since_s", [](auto& v) { return Duration(v.now - v.missing.since); }},
      Field{"rtt_s", [](auto&) { return nullptr; }},
      Field{"clock", [](auto&) { return nullptr; }}};
};

template <>
struct Fields<link::ClockOffset::Sample> {
  using Sample = link::ClockOffset::Sample;
  static constexpr std::tuple list{
      Field{"offset_s", [](auto& s) { return static_cast<double>(s.offset) * 1e-9; }},
      Field{"uncertainty_s", [](auto& s) { return static_cast<double>(s.round_trip) * 0.5e-9; }}};
};

// One path of a link.
struct PathView {
  const link::Links& links;
  const link::Paths& paths;
  const link::Path& path;
  Time now{};
};
template <>
struct Fields<PathView> {
  using View = PathView;
  static std::optional<Duration> since(const View& v) {
    return v.path.since == Time() ? std::nullopt : std::optional(Duration(v.now - v.path.since));
  }
  static boost::json::array targets(const View& v);
  static std::optional<std::string> peer_address(const View& v);
  static constexpr std::tuple list{
      Field{"path", [](auto& v) { return v.path.kind; }},
      Field{"used", [](auto& v) { return v.paths.address() && v.path.kind == v.paths.kind(); }},
      Field{"works", [](auto& v) { return v.path.works; }},
      Field{"trouble",
            [](auto& v) { return unless_empty(std::string(v.links.trouble(v.path.kind))); }},
      Field{"since_s", since},
      Field{"peer_address", peer_address},
      Field{"targets", targets},
      Field{"datagrams_in", [](auto& v) { return v.path.counters.datagrams_in; }},
      Field{"datagrams_out", [](auto& v) { return v.path.counters.datagrams_out; }},
      Field{"wire_bytes_in", [](auto& v) { return v.path.counters.bytes_in; }},
      Field{"wire_bytes_out", [](auto& v) { return v.path.counters.bytes_out; }}};
};

// The router at the other end of a link.
struct RouterView {
  RouterView(const link::Link& one, Time at) : link(one), now(at) {}
  [[nodiscard]] bool is_known() const { return link.peer().epoch != 0; }

  const link::Link& link;
  Time now{};
};
// The fields that reports of routers and of links have in common.
struct RouterFields {
  using View = RouterView;
  static std::optional<link::Identity> peer(const View& v) {
    return v.is_known() ? std::optional(v.link.peer()) : std::nullopt;
  }
  static std::optional<std::string_view> via(const View& v) {
    return unless_empty(v.is_known() ? v.link.peer().name.view()
                                     : std::string_view(v.link.settings().to));
  }
  static std::optional<Duration> rtt(const View& v) {
    return v.link.is_up() && v.link.rtt().known() ? std::optional(v.link.rtt().smoothed())
                                                  : std::nullopt;
  }
  static std::optional<link::ClockOffset::Sample> clock(const View& v) {
    return v.link.is_up() ? v.link.clock() : std::nullopt;
  }
  static constexpr Field who{"", peer};
  static constexpr Field kind{"kind", [](auto& v) { return v.link.settings().kind; }};
  static constexpr std::tuple rest{
      Field{"via", via}, Field{"since_s", [](auto& v) { return Duration(v.now - v.link.since()); }},
      Field{"to", [](auto& v) { return unless_empty(std::string_view(v.link.settings().to)); }},
      Field{"rtt_s", rtt}, Field{"clock", clock}};
};
template <>
struct Fields<RouterView> : RouterFields {
  static constexpr std::tuple list = std::tuple_cat(
      std::tuple{who, kind, Field{"state", [](auto& v) { return v.link.is_up() ? "up" : "down"; }}},
      rest);
};

// One link with all its state. `client`: the router's counters for it; null when there are none.
struct LinkView : RouterView {
  LinkView(const link::Links& all, const link::Link& one, const core::Router& router, Time at)
      : RouterView(one, at), links(all), client(router.client(one.client())) {}

  [[nodiscard]] const auto& session() const { return link.session(); }
  [[nodiscard]] const auto& counters() const { return session().counters(); }

  const link::Links& links;
  const core::Client* client;
};
template <>
struct Fields<LinkView> : RouterFields {
  using View = LinkView;
  static std::optional<Duration> path_since(const View& v) {
    return v.link.is_up() ? std::optional(Duration(v.now - v.link.paths().since())) : std::nullopt;
  }
  static std::optional<Duration> last_received(const View& v) {
    return v.link.last_received() == Time()
               ? std::nullopt
               : std::optional(Duration(v.now - v.link.last_received()));
  }
  static boost::json::array paths(const View& v);
  static std::optional<std::string> peer_address(const View& v);
  static boost::json::array queue_bytes(const View& v);
  // Sorted by name and kind: there are few links, and their order rarely changes.
  static constexpr std::tuple list = std::tuple_cat(
      std::tuple{who, kind, Field{"state", [](auto& v) { return v.link.state(); }}}, rest,
      std::tuple{
          Field{"peer",
                [](auto& v) {
                  return v.is_known() ? unless_empty(v.link.peer().name.view()) : std::nullopt;
                }},
          Field{"connects", [](auto& v) { return v.link.settings().connects; }},
          Field{"active", [](auto& v) { return &v.link == v.links.uplink(); }},
          Field{"path", [](auto& v) { return v.link.paths().kind(); }},
          Field{"path_why",
                [](auto& v) { return unless_empty(std::string(v.link.paths().why())); }},
          Field{"path_since_s", path_since},
          Field{"paths", paths},
          Field{"peer_address", peer_address},
          Field{"refusal",
                [](auto& v) { return unless_empty(std::string(v.link.refusal().view())); }},
          Field{"heard_s", last_received},
          Field{"keep_alive_s", [](auto& v) { return v.link.settings().keep_alive; }},
          Field{"loss_in", [](auto& v) { return v.session().loss_permille() / 1000.0; }},
          Field{"loss_out", [](auto& v) { return v.link.their_loss_permille() / 1000.0; }},
          Field{"mtu_bytes", [](auto& v) { return v.session().mtu(); }},
          Field{"window_bytes", [](auto& v) { return v.session().congestion().window(); }},
          Field{"in_flight_bytes", [](auto& v) { return v.session().in_flight(); }},
          Field{"queue_delay_s", [](auto& v) { return v.session().congestion().queue_delay(); }},
          Field{"rate_limit_bytes_per_s", [](auto& v) { return v.link.settings().session.rate; }},
          Field{"queue_bytes", queue_bytes},
          Field{"packets_in", [](auto& v) { return v.counters().packets_in; }},
          Field{"packets_out", [](auto& v) { return v.counters().packets_out; }},
          Field{"packets_lost", [](auto& v) { return v.counters().packets_lost; },
                counter(4, "tims_link_packets_lost_total", "Packets that did not arrive there.")},
          Field{"packets_duplicate", [](auto& v) { return v.counters().packets_duplicate; }},
          Field{"sample_repeats", [](auto& v) { return v.counters().sample_repeats; }},
          Field{"samples_incomplete",
                [](auto& v) { return v.session().samples_in().incomplete(); }},
          Field{"samples_overtaken", [](auto& v) { return v.session().samples_in().overtaken(); }},
          Field{"wire_bytes_in", [](auto& v) { return v.counters().bytes_in; },
                counter(6, "tims_link_received_bytes_total", "Bytes of the datagrams that came.")},
          Field{"wire_bytes_out", [](auto& v) { return v.counters().bytes_out; },
                counter(5, "tims_link_sent_bytes_total", "Bytes of the datagrams that were sent.")},
          Field{"mailboxes", [](auto& v) { return v.link.mailboxes(); }},
          Field{"mailboxes_refused", [](auto& v) { return v.link.mailboxes_refused(); }},
          Field{"in_messages",
                [](auto& v) { return v.client == nullptr ? 0 : v.client->in.messages; }},
          Field{"in_bytes", [](auto& v) { return v.client == nullptr ? 0 : v.client->in.bytes; }},
          Field{"out_messages",
                [](auto& v) { return v.client == nullptr ? 0 : v.client->out.messages; }},
          Field{"out_bytes", [](auto& v) { return v.client == nullptr ? 0 : v.client->out.bytes; }},
          Field{"drops",
                [](auto& v) { return v.client == nullptr ? 0 : v.client->dropped.messages; }},
          Field{"", [](auto& v) { return v.link.is_up(); },
                gauge(1, "tims_link_up", "1 while messages pass over the link.")},
          Field{"", [](auto& v) { return v.link.rtt().smoothed(); },
                gauge(2, "tims_link_rtt_seconds", "Round trip to the router at its other end.")},
          Field{"", [](auto& v) { return v.session().queued_bytes(); },
                gauge(3, "tims_link_queue_bytes",
                      "What waits for the link, or to be acknowledged.")}});
};

// A router that announces itself in the fleet.
struct AnnouncementView {
  const link::Links& links;
  const link::Announcement& announcement;
};
template <>
struct Fields<AnnouncementView> {
  using View = AnnouncementView;
  static boost::json::array udp(const View& v);
  static bool linked(const View& v);
  static constexpr std::tuple list{
      Field{"", [](auto& v) { return v.announcement.who; }}, Field{"udp", udp},
      Field{"dds", [](auto& v) { return v.announcement.dds.to_string(); }},
      Field{"linked", linked}};
};

// --- metrics

// The router's counters in Prometheus' text format (version 0.0.4). Label values come from closed
// lists, so the page stays short however many mailboxes and clients there are.
std::string metrics_text(const AdminSource& source, Time now);

}  // namespace tims::io
