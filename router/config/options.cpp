#include "router/config/options.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include <fmt/core.h>

namespace tims::config {
namespace {

// --- access of a table row to its member of Config

constexpr std::int64_t kKi = 1LL << 10;
constexpr std::int64_t kGi = 1LL << 30;
constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kHour = 3'600'000 * kMs;

// Conversion between a member of Config and a Value.
template <Kind kind, typename T>
Value to_value(const T& member) {
  if constexpr (kind == Kind::kSize) return Bytes{std::int64_t{member}};
  if constexpr (kind == Kind::kRate) return Rate{static_cast<std::int64_t>(member)};
  if constexpr (kind == Kind::kNumber) return std::int64_t{member};
  return member;
}

template <Kind kind, typename T>
void from_value(T& member, const Value& value) {
  if constexpr (kind == Kind::kSize)
    member = static_cast<T>(std::get<Bytes>(value).count);
  else if constexpr (kind == Kind::kRate)
    member = static_cast<T>(std::get<Rate>(value).bytes_per_second);
  else if constexpr (kind == Kind::kNumber)
    member = static_cast<T>(std::get<std::int64_t>(value));
  else
    member = std::get<T>(value);
}

bool always(const Config& /*config*/, std::size_t /*index*/) { return true; }

// The struct that contains the member: a table of Config, or one item of a list of Config.
template <auto holder, typename AnyConfig>
auto& held(AnyConfig& config, [[maybe_unused]] std::size_t index) {
  if constexpr (requires { (config.*holder).at(index); })
    return (config.*holder).at(index);
  else
    return config.*holder;
}

// A row: access to the value, and its description.
template <Kind kind, auto holder, auto member>
constexpr Option row(Spec spec) {
  spec.kind = kind;
  return {spec,
          [](const Config& c, std::size_t i) { return to_value<kind>(held<holder>(c, i).*member); },
          [](Config& c, std::size_t i, const Value& value) {
            from_value<kind>(held<holder>(c, i).*member, value);
          },
          always};
}

// --- the options

// Sizeof(sockaddr_un::sun_path) minus the terminating zero.
constexpr std::int64_t kSocketPathMax = 107;

constexpr std::array kOptions{
    row<Kind::kText, &Config::router, &Config::Router::name>(
        {.key = "router.name",
         .range = {1, 64},
         .reload = Reload::kRestart,
         .help = "Name of this router for users: used in log lines, refusals and metrics.",
         .default_note = "the host's name",
         .sample = R"("${HOSTNAME}")"}),
    row<Kind::kRole, &Config::router, &Config::Router::role>(
        {.key = "router.role",
         .reload = Reload::kRestart,
         .help = "Position in the tree of routers: a subsystem router has at most a super router, "
                 "a system router represents one robot, a top-level router connects robots."}),
    row<Kind::kNumber, &Config::router, &Config::Router::system>(
        {.key = "router.system",
         .range = {0, kIdMax},
         .reload = Reload::kRestart,
         .help = "System (robot) this router belongs to: the first field of its address "
                 "Tims(system/id); 0 for a top-level router. Above 255 it needs a wider field "
                 "of address.widths."}),
    row<Kind::kNumber, &Config::router, &Config::Router::id>(
        {.key = "router.id",
         .range = {0, kIdMax},
         .reload = Reload::kRestart,
         .help = "Number of this router within its system; must be unique in the system. Above 255 "
                 "it needs a wider field of address.widths."}),
    row<Kind::kNumber, &Config::router, &Config::Router::priority>(
        {.key = "router.priority",
         .range = {0, 99},
         .reload = Reload::kRestart,
         .help = "Real-time priority (SCHED_FIFO) of the thread that carries messages, whose "
                 "memory is then locked; 0 for none. Corresponds to the original's -P. Requires "
                 "LimitRTPRIO and LimitMEMLOCK of a unit, or ulimit -r and -l; without them the "
                 "router warns and runs as an ordinary process."}),

    row<Kind::kWidths, &Config::address, &Config::AddressBits::widths>(
        {.key = "address.widths",
         .reload = Reload::kRestart,
         .help = "Bits of each field of an address (system/class/instance/local), 32 in all and at "
                 "least 1 each; the same for every router and component of a fleet. With "
                 "\"12/8/6/6\" up to 4095 robots have a system each."}),

    row<Kind::kText, &Config::unix, &Config::Unix::path>(
        {.key = "unix.path",
         .range = {1, kSocketPathMax},
         .reload = Reload::kRestart,
         .help = "Socket for the components of this host.",
         .default_note = "/run/tims/router.sock for root, else "
                         "$XDG_RUNTIME_DIR/tims/router.sock, else /tmp/tims-UID/router.sock",
         .sample = R"("/run/tims/router.sock")"}),
    row<Kind::kFlag, &Config::unix, &Config::Unix::everybody>(
        {.key = "unix.everybody",
         .reload = Reload::kRestart,
         .help = "Lets every user of this host connect components; otherwise the user the router "
                 "runs as, and the members of its group."}),

    row<Kind::kEndpoint, &Config::tcp, &Config::Tcp::listen>(
        {.key = "tcp.listen",
         .reload = Reload::kRestart,
         .help = "Address for connections of original RACK programs and remote clients; \"off\" "
                 "for none, port 0 for any free port. Beyond loopback it needs security.keys, and "
                 "then TLS and a certificate (see tcp.plain), or security.insecure. "
                 "Any program that can reach the port can command every component; on loopback "
                 "this includes every user of this host. Where users do not trust each other, set "
                 "this and http.listen to \"off\", so that unix.path is the only entry."}),
    row<Kind::kText, &Config::tcp, &Config::Tcp::plain>(
        {.key = "tcp.plain",
         .range = {0, 1024},
         .reload = Reload::kYes,
         .help = "Networks whose clients of tcp.listen may speak in the clear, as original RACK "
                 "programs do, when this router has keys: \"loopback, 10.9.0.0/16\". All others "
                 "need TLS and a certificate of the fleet; timsctl tunnel brings original programs "
                 "through. Without keys, everybody speaks in the clear.",
         .is_list = true}),
    row<Kind::kFlag, &Config::tcp, &Config::Tcp::admin>(
        {.key = "tcp.admin",
         .reload = Reload::kYes,
         .help =
             "Lets clients of tcp.listen and http.listen change this router: take links down, "
             "add routes, inject faults; otherwise only programs that connect to unix.path, and "
             "other routers."}),
    row<Kind::kFlag, &Config::tcp, &Config::Tcp::compat_delete>(
        {.key = "tcp.compat_delete",
         .reload = Reload::kYes,
         .help = "Lets any TCP client delete any mailbox, as the original router did; "
                 "otherwise only the client that registered it."}),
    row<Kind::kSize, &Config::tcp, &Config::Tcp::queue_bytes>(
        {.key = "tcp.queue",
         .range = {64 * kKi, kGi},
         .reload = Reload::kYes,
         .help = "Maximum amount of data queued for one slow TCP client; beyond it messages are "
                 "dropped and counted, the least important first."}),

    row<Kind::kEndpoint, &Config::http, &Config::Http::listen>(
        {.key = "http.listen",
         .reload = Reload::kRestart,
         .help = "Address for WebSocket clients, /metrics and /healthz; \"off\" for none. Beyond "
                 "loopback it needs security.keys, and then HTTPS and a login (timsctl web), or "
                 "security.insecure."}),
    row<Kind::kText, &Config::http, &Config::Http::names>(
        {.key = "http.names",
         .range = {0, 1024},
         .reload = Reload::kYes,
         .help = "Names by which browsers reach this host, in addition to numeric addresses and "
                 "localhost: \"robot7.local, robot7\". Requests with another name are refused, "
                 "because any web site can point a name of its own at this host.",
         .is_list = true}),
    row<Kind::kText, &Config::http, &Config::Http::origins>(
        {.key = "http.origins",
         .range = {0, 1024},
         .reload = Reload::kYes,
         .help = "Web pages that may open a WebSocket here in addition to pages served by this "
                 "port: \"http://robot7:3000, http://localhost:5173\".",
         .is_list = true}),
    row<Kind::kText, &Config::http, &Config::Http::certificate>(
        {.key = "http.certificate",
         .range = {0, 4096},
         .reload = Reload::kRestart,
         .help = "PEM file with a certificate for browsers and those that issued it, of an "
                 "authority that they know; without it, that of security.keys is shown, whose root "
                 "(fleet.pem) must be imported into the browser once.",
         .default_note = "the certificate of security.keys",
         .sample = R"("")"}),
    row<Kind::kText, &Config::http, &Config::Http::key>(
        {.key = "http.key",
         .range = {0, 4096},
         .reload = Reload::kRestart,
         .help = "PEM file with the private key of http.certificate (P-256), readable by the "
                 "router's user only.",
         .default_note = "the key of security.keys",
         .sample = R"("")"}),
    row<Kind::kText, &Config::http, &Config::Http::console>(
        {.key = "http.console",
         .range = {0, 4096},
         .reload = Reload::kRestart,
         .help = "Folder of the console, the web page at http.listen; it is read once, at start. "
                 "\"off\" for none.",
         .default_note = "share/tims/console of this installation or build, if it is there",
         .sample = R"("")"}),
    row<Kind::kSize, &Config::http, &Config::Http::queue_bytes>(
        {.key = "http.queue",
         .range = {64 * kKi, kGi},
         .reload = Reload::kYes,
         .help = "Maximum amount of data queued for one slow WebSocket client; beyond it messages "
                 "are dropped and counted, the least important first. One message that is larger "
                 "may wait in addition."}),

    row<Kind::kEndpoint, &Config::udp, &Config::Udp::listen>(
        {.key = "udp.listen",
         .reload = Reload::kRestart,
         .help = "Address for datagrams of other routers, see [[link]]; \"off\" for none. Beyond "
                 "loopback it needs security.keys or security.insecure.",
         .default_note = "127.0.0.1:2010, with security.keys or security.insecure 0.0.0.0:2010",
         .sample = R"("127.0.0.1:2010")"}),

    row<Kind::kText, &Config::fleet, &Config::Fleet::name>(
        {.key = "fleet.name",
         .range = {0, 63},
         .reload = Reload::kRestart,
         .help = "Fleet of this router: routers with the same name find each other by DDS, see "
                 "link.to and link.paths. Routers of other fleets are ignored. Empty: none."}),

    row<Kind::kNumber, &Config::dds, &Config::Dds::domain>(
        {.key = "dds.domain",
         .range = {0, 232},
         .reload = Reload::kRestart,
         .help = "DDS domain of the fleet: its number determines the UDP ports that DDS uses."}),
    row<Kind::kFlag, &Config::dds, &Config::Dds::multicast>(
        {.key = "dds.multicast",
         .reload = Reload::kRestart,
         .help = "Looks for routers by multicast; otherwise only at dds.peers and dds.server."}),
    row<Kind::kText, &Config::dds, &Config::Dds::peers>(
        {.key = "dds.peers",
         .range = {0, 1024},
         .reload = Reload::kRestart,
         .help = "Addresses of routers that multicast does not reach: \"10.9.1.1, 10.9.1.2:7410\". "
                 "It is enough when one side lists the other.",
         .is_list = true}),
    row<Kind::kText, &Config::dds, &Config::Dds::server>(
        {.key = "dds.server",
         .range = {0, 64},
         .reload = Reload::kRestart,
         .help = "Address of a discovery server (timsctl fleet server) that announces all routers, "
                 "such as \"10.9.1.1:11811\"; with it, no other discovery is used."}),
    row<Kind::kDuration, &Config::dds, &Config::Dds::lease>(
        {.key = "dds.lease",
         .range = {500 * kMs, kHour},
         .reload = Reload::kRestart,
         .help = "Time without an announcement after which a router is removed from the fleet."}),
    row<Kind::kSize, &Config::dds, &Config::Dds::message_max>(
        {.key = "dds.message",
         .range = {512, 65500},
         .reload = Reload::kRestart,
         .help = "Largest datagram of DDS. Datagrams larger than the MTU are sent as IP fragments: "
                 "faster on a network without loss, but with packet loss no message may arrive."}),
    row<Kind::kNumber, &Config::dds, &Config::Dds::history>(
        {.key = "dds.history",
         .range = {2, 1024},
         .reload = Reload::kRestart,
         .help = "Number of samples of up to 64 KiB that one router may leave unacknowledged. "
                 "Further messages are queued, with the rules of a full queue."}),
    row<Kind::kDuration, &Config::dds, &Config::Dds::heartbeat>(
        {.key = "dds.heartbeat",
         .range = {kMs, 1000 * kMs},
         .reload = Reload::kRestart,
         .help = "Interval of heartbeats to a router that has not acknowledged everything; lost "
                 "samples are sent again after this time."}),
    row<Kind::kText, &Config::dds, &Config::Dds::profiles>(
        {.key = "dds.profiles",
         .range = {0, 255},
         .reload = Reload::kRestart,
         .help = "File with XML profiles of Fast DDS; its participant, data_writer and data_reader "
                 "profiles named \"tims\" are used."}),

    row<Kind::kFlag, &Config::dds, &Config::Dds::beyond_host>(
        {.key = "dds.beyond_host",
         .reload = Reload::kRestart,
         .help =
             "Lets DDS of a router with keys (security.keys) speak with other hosts. Links over "
             "DDS are sealed as over UDP, but everybody on the network reaches the library "
             "itself, in which faults are known that are not mended: tims-router --check names "
             "them. Without keys, security.insecure decides."}),

    row<Kind::kSize, &Config::message, &Config::Message::bytes_max>(
        {.key = "message.max",
         .range = {64 * kKi, kGi},
         .reload = Reload::kRestart,
         .help = "Largest message, including its 16-byte header. The original's limit is 262144B; "
                 "below 64KiB ordinary laser scans would not fit."}),
    row<Kind::kClasses, &Config::message, &Config::Message::classes>(
        {.key = "message.classes",
         .reload = Reload::kRestart,
         .help = "Lowest priorities of the classes 1, 2, ... 7 of a link; texts for users are "
                 "class 0. Classes 4 to 7 may use the reserve of a link's rate, 5 to 7 are urgent. "
                 "Must be the same for all routers of a fleet: a link between routers with "
                 "different values is refused."}),
    row<Kind::kText, &Config::message, &Config::Message::lifetimes>(
        {.key = "message.lifetimes",
         .range = {0, 4096},
         .reload = Reload::kYes,
         .help = "How long commands are worth delivering, 20ms to 10min: types as in [[rule]], and "
                 "a time. An older one does not arrive over a link that was cut and has healed, "
                 "and its sender is told. The default for speeds is three periods of a pilot.",
         .is_list = true}),

    row<Kind::kDuration, &Config::lifesign, &Config::Lifesign::interval>(
        {.key = "lifesign.interval",
         .range = {100 * kMs, kHour},
         .reload = Reload::kYes,
         .help = "Interval of lifesigns to TCP clients; a client that has not answered when the "
                 "next one is due is disconnected. Original Java clients disconnect when they "
                 "receive nothing for 10s."}),

    row<Kind::kNumber, &Config::limits, &Config::Limits::clients>(
        {.key = "limits.clients",
         .range = {1, 16384},
         .reload = Reload::kYes,
         .help = "Maximum number of connected clients, over all ports. A quarter is reserved for "
                 "programs of this host; browser pages have at most another quarter. When there is "
                 "no room left for TCP, clients that have not sent anything yet are disconnected "
                 "to make room for new ones."}),
    row<Kind::kNumber, &Config::limits, &Config::Limits::mailboxes_per_client>(
        {.key = "limits.mailboxes_per_client",
         .range = {1, 1048576},
         .reload = Reload::kYes,
         .help = "Maximum number of mailboxes one client may register."}),

    row<Kind::kSize, &Config::newest, &Config::Newest::bytes>(
        {.key = "newest.bytes",
         .range = {0, kGi},
         .reload = Reload::kRestart,
         .help = "Memory for the newest values of streams that passed this router: who comes late "
                 "gets them at once, with their age (timsctl component data --newest, console), "
                 "also when their robot is away. One value for each KiB; when it is full, those "
                 "that were not renewed for the longest time are removed. 0B for none."}),
    row<Kind::kSize, &Config::newest, &Config::Newest::length_max>(
        {.key = "newest.message",
         .range = {16, 112 * kKi},
         .reload = Reload::kYes,
         .help = "Largest message that is kept as a newest value, including its header."}),
    row<Kind::kText, &Config::newest, &Config::Newest::streams>(
        {.key = "newest.streams",
         .range = {0, 1024},
         .reload = Reload::kYes,
         .help = "The streams whose newest value is kept: \"status\" (on, off) and "
                 "\"parameters\" of all components, \"state\": the data of the classes that "
                 "describe a state (Chassis, Clock, Compass, FeatureMap, Gps, GridMap, Io, Mcl, "
                 "ObjRecog, Odometry, Path, Pilot, Planner, Position, PtzDrive, ServoDrive, "
                 "Vehicle), the names of other classes, \"*\" for the data of all classes.",
         .is_list = true}),

    row<Kind::kLogLevel, &Config::log, &Config::Log::level>(
        {.key = "log.level", .reload = Reload::kYes, .help = "Lowest severity that is logged."}),

    row<Kind::kFlag, &Config::security, &Config::Security::insecure>(
        {.key = "security.insecure",
         .reload = Reload::kRestart,
         .help = "Allows listening beyond loopback without security.keys: any program that can "
                 "reach the port can command the robot. Use it only in networks where every "
                 "machine is trusted."}),
    row<Kind::kText, &Config::security, &Config::Security::keys>(
        {.key = "security.keys",
         .range = {0, 4096},
         .reload = Reload::kRestart,
         .help = "Folder with the keys of this router, made by timsctl key init (base) or timsctl "
                 "join. Its certificate must name the role, system and id of this router. What "
                 "timsctl changes there takes effect within a second, without a reload."}),
    row<Kind::kFlag, &Config::security, &Config::Security::refuse_expired>(
        {.key = "security.refuse_expired",
         .reload = Reload::kRestart,
         .help = "Refuses expired certificates of others, if the clock of this host is "
                 "synchronised. Otherwise they are accepted, so that no clock stops a robot."}),
    row<Kind::kDuration, &Config::security, &Config::Security::list_age_max>(
        {.key = "security.list_age_max",
         .range = {0, std::int64_t{3650} * 24 * kHour},
         .reload = Reload::kRestart,
         .help = "A list of revoked certificates that is older than this is reported (log, status, "
                 "timsctl doctor), if the clock of this host is synchronised; 0: a list may have "
                 "any age. timsctl key serve makes a new one each day, so several days are "
                 "sensible."}),
    row<Kind::kFlag, &Config::security, &Config::Security::refuse_old_list>(
        {.key = "security.refuse_old_list",
         .reload = Reload::kRestart,
         .help = "While the list is older than security.list_age_max, refuses new connections of "
                 "users and of routers of other robots, whose certificates may have been revoked "
                 "meanwhile. Routers above and those of the same robot are accepted, and what is "
                 "connected stays, so that no clock stops a robot."}),
    row<Kind::kDuration, &Config::security, &Config::Security::renew_within>(
        {.key = "security.renew_within",
         .range = {0, 24 * kHour},
         .reload = Reload::kRestart,
         .help = "A certificate that is due to be renewed is renewed within this time after the "
                 "start of the router, or after a new list of the fleet, at a random moment, so "
                 "that the routers of a fleet do not ask the base at once."}),

    row<Kind::kFlag, &Config::sim, &Config::Sim::faults>(
        {.key = "sim.faults",
         .reload = Reload::kYes,
         .help = "Allows timsctl sim fault to drop and delay UDP datagrams of this router; only "
                 "for tests."}),
};

// --- the items of lists: [[link]] and [[route]]

// The destination of a link is one key and two members.
constexpr Option destination_row(Spec spec) {
  spec.kind = Kind::kDestination;
  return {spec,
          [](const Config& c, std::size_t i) -> Value {
            return Destination{c.links.at(i).host, c.links.at(i).port};
          },
          [](Config& c, std::size_t i, const Value& value) {
            const auto& to = std::get<Destination>(value);
            c.links.at(i).host = to.host;
            c.links.at(i).port = to.port;
          },
          [](const Config& c, std::size_t i) { return !c.links.at(i).accepts(); }};
}

constexpr Option accepted_system_row(const Spec& spec) {
  Option option = row<Kind::kSystem, &Config::links, &Link::system>(spec);
  option.has_value = [](const Config& c, std::size_t i) { return c.links.at(i).accepts(); };
  return option;
}

// Without keys there is nothing to choose.
constexpr Option secure_row(const Spec& spec) {
  Option option = row<Kind::kFlag, &Config::links, &Link::secure>(spec);
  option.has_value = [](const Config& c, std::size_t i) {
    return !c.security.keys.empty() || !c.links.at(i).secure;
  };
  return option;
}

constexpr std::array kLinkOptions{
    row<Kind::kLinkKind, &Config::links, &Link::kind>(
        {.key = "link.kind",
         .help = "Role of the other router relative to this one: its super router (further super "
                 "links are used in order of preference), a peer, or a router below it.",
         .default_note = "none: required"}),
    destination_row({.key = "link.to",
                     .help = "Address this side connects to; the default port is 2010. Beyond "
                             "loopback it needs security.keys or security.insecure. \"auto\" finds "
                             "the super router "
                             "in the fleet, by role and system. Required for a super link, not "
                             "allowed for a sub link; a peer link without it accepts.",
                     .default_note = "none: this side accepts"}),
    accepted_system_row({.key = "link.system",
                         .help = "Routers this side accepts: those of this system, \"*\" for any. "
                                 "Only for links that accept."}),
    row<Kind::kPaths, &Config::links, &Link::paths>(
        {.key = "link.paths",
         .help =
             "Paths to the other router in order of preference: \"udp\", \"dds\", \"tcp\". A later "
             "path carries the link while the earlier ones do not work. dds requires fleet.name; "
             "tcp is for networks that let no UDP through: the side that connects makes one TCP "
             "connection to the same address, where the other one listens for TCP, too, if this "
             "stands in its [[link]].",
         .default_note = R"(["udp"], with fleet.name ["udp", "dds"] where dds leaves this host)",
         .sample = R"(["udp", "dds"])"}),
    row<Kind::kText, &Config::links, &Link::name>(
        {.key = "link.name", .range = {0, 64}, .help = "Label of the link, for display."}),
    row<Kind::kNumber, &Config::links, &Link::mailboxes>(
        {.key = "link.mailboxes",
         .range = {1, 1048576},
         .help = "Maximum number of mailboxes the other router may announce over this link; "
                 "further ones are refused and logged. A link for one system (link.system) accepts "
                 "only mailboxes and messages of that system."}),
    row<Kind::kDuration, &Config::links, &Link::interval>(
        {.key = "link.interval",
         .range = {50 * kMs, 10'000 * kMs},
         .help = "Interval of keep-alives; the link is down after three are missed."}),
    row<Kind::kRate, &Config::links, &Link::rate>(
        {.key = "link.rate",
         .range = {10'000, 100'000'000'000},
         .help = "Maximum number of bytes per second this router sends; 0 for no limit."}),
    row<Kind::kNumber, &Config::links, &Link::reserve>(
        {.key = "link.reserve",
         .range = {0, 90},
         .help = "Percentage of the rate that is reserved for the upper priority classes."}),
    row<Kind::kDuration, &Config::links, &Link::lifetime>(
        {.key = "link.lifetime",
         .range = {100 * kMs, kHour},
         .help = "How long the router tries to deliver a reliable message before it is dropped and "
                 "counted."}),
    row<Kind::kCompression, &Config::links, &Link::compress>(
        {.key = "link.compress",
         .help =
             "Compression of the sensor data this router sends: \"lz4\" costs little, \"zstd\" "
             "saves more, \"auto\" chooses by the rate of the link, and nothing from 1 Gbit/s "
             "on. Data of 512 B to 1 MiB that gain by it, never texts, commands, administration "
             "or priorities of 45 and more."}),
    row<Kind::kFlag, &Config::links, &Link::compress_own>(
        {.key = "link.compress_own",
         .help = "Also compresses data of classes that RACK does not know. The size of compressed "
                 "data tells a listener something about them, also when they are encrypted."}),
    secure_row(
        {.key = "link.secure",
         .help = "Of a router with keys (security.keys): false makes this link one without. Both "
                 "sides must say so; neither falls back by itself."}),
};

constexpr std::array kRouteOptions{
    row<Kind::kText, &Config::routes, &Route::match>(
        {.key = "route.match",
         .range = {1, 64},
         .help = "Destinations of the route: an address pattern such as \"Ladar(3/*)\".",
         .default_note = "none: required"}),
    row<Kind::kText, &Config::routes, &Route::via>(
        {.key = "route.via",
         .range = {1, 64},
         .help = "Name of the router at the other end of a link: the one in its certificate, or "
                 "router.name of a router without keys.",
         .default_note = "none: required"}),
};

constexpr std::array kRuleOptions{
    row<Kind::kText, &Config::rules, &Rule::name>(
        {.key = "rule.name",
         .range = {1, 64},
         .help = "Name of the rule, in counters, refusals and tests.",
         .default_note = "none: required"}),
    row<Kind::kText, &Config::rules, &Rule::from>(
        {.key = "rule.from",
         .range = {1, 4096},
         .help = "Who sends: uid:1000, gid:100, unit:laser.service, label:NAME, own (the router's "
                 "user, root and the router's group), user:NAME, right:drive, net:10.9.0.0/16 (an "
                 "address is no proof), port:tcp. A star may end a name. Routers are met only by "
                 "router:NAME, system:3, role:subsystem, other-robot; without such a rule they "
                 "may do everything, since messages are judged where they enter the fleet, but "
                 "with keys other robots do not change routers and their files.",
         .is_list = true}),
    row<Kind::kText, &Config::rules, &Rule::to>(
        {.key = "rule.to",
         .range = {1, 4096},
         .help = "Destinations: patterns of addresses such as \"Chassis(3/*)\".",
         .is_list = true}),
    row<Kind::kText, &Config::rules, &Rule::types>(
        {.key = "rule.types",
         .range = {1, 4096},
         .help = "Types of messages: commands, replies (data too), look, drive, names such as "
                 "chassis.move (timsctl msg types), numbers such as 20..29; and what a router is "
                 "asked for: look, change, agree, login; and trace.",
         .is_list = true}),
    row<Kind::kNumber, &Config::rules, &Rule::priority_max>(
        {.key = "rule.priority_max",
         .range = {0, 255},
         .help = "A higher priority is lowered to this one."}),
    row<Kind::kRate, &Config::rules, &Rule::rate>(
        {.key = "rule.rate",
         .range = {1, 100'000'000'000},
         .help = "Maximum bytes per second of each sender (all its connections), and at once as "
                 "many as in one second; what is above is denied. 0 for no limit."}),
    row<Kind::kText, &Config::rules, &Rule::then>(
        {.key = "rule.then",
         .range = {1, 16},
         .help = "allow; deny; observe (let pass, and report what deny would have stopped); thin "
                 "(of streams only: leave out samples, by the keys that follow). The first rule "
                 "that matches decides; what matches none is denied. Answers within a minute need "
                 "no rule.",
         .default_note = "none: required"}),
    row<Kind::kNumber, &Config::rules, &Rule::per_second>(
        {.key = "rule.per_second",
         .range = {0, 100'000},
         .help = "thin: at most so many samples of a stream a second; 0 for no limit."}),
    row<Kind::kNumber, &Config::rules, &Rule::every>(
        {.key = "rule.every",
         .range = {0, 1'000'000},
         .help = "thin: only every so manyth sample of a stream; 0 for all."}),
    row<Kind::kSize, &Config::rules, &Rule::bytes_max>(
        {.key = "rule.bytes_max",
         .range = {0, 1 << 30},
         .help = "thin: no samples longer than this; 0 for no limit."}),
};

constexpr std::array kTestOptions{
    row<Kind::kText, &Config::tests, &Test::name>({.key = "test.name",
                                                   .range = {1, 64},
                                                   .help = "Name of the test.",
                                                   .default_note = "none: required"}),
    row<Kind::kText, &Config::tests, &Test::from>(
        {.key = "test.from",
         .range = {1, 4096},
         .help = "Who sends: \"user:guest\", or several identities of one sender.",
         .default_note = "none: required",
         .is_list = true}),
    row<Kind::kText, &Config::tests, &Test::to>({.key = "test.to",
                                                 .range = {1, 64},
                                                 .help = "To which address.",
                                                 .default_note = "none: required"}),
    row<Kind::kText, &Config::tests, &Test::type>(
        {.key = "test.type",
         .range = {1, 64},
         .help = "Which type of message, as in rule.types, but a single one.",
         .default_note = "none: required"}),
    row<Kind::kNumber, &Config::tests, &Test::priority>(
        {.key = "test.priority", .range = {0, 255}, .help = "With which priority."}),
    row<Kind::kText, &Config::tests, &Test::expect>(
        {.key = "test.expect",
         .range = {1, 16},
         .help = "What the rules must say: allow, deny or observe. A configuration with a test "
                 "that fails is refused.",
         .default_note = "none: required"}),
};

template <auto items>
constexpr List list(std::string_view name, std::span<const Option> rows) {
  return {.name = name,
          .help = {},
          .sample_items = {},
          .sample_setting = {},
          .options = rows,
          .size = [](const Config& c) { return (c.*items).size(); },
          .append = [](Config& c) { (c.*items).emplace_back(); },
          .copy = [](Config& to, const Config& from) { to.*items = from.*items; },
          .label = [](const Config& c, std::size_t i) { return (c.*items).at(i).to_string(); }};
}

constexpr List link_list() {
  List links = list<&Config::links>("link", kLinkOptions);
  links.help =
      "Links to other routers: one [[link]] for each router this side connects to, and for each "
      "group of routers it accepts.";
  links.sample_items = R"toml([[link]]
kind = "super"
to = "10.9.1.1:2010"

[[link]]                        # used when the first is not available
kind = "super"
to = "fleet.example.org"
rate = "6MB"

[[link]]                        # found in the fleet, see [fleet]
kind = "super"
to = "auto"
paths = ["udp", "dds"]

[[link]]
kind = "peer"
to = "robot2:2010"

[[link]]                        # at a system router: its subsystem routers
kind = "sub"
system = 1
)toml";
  links.sample_setting = "link='kind=super,to=10.9.1.1:2010'";
  return links;
}

constexpr List route_list() {
  List routes = list<&Config::routes>("route", kRouteOptions);
  routes.help =
      "Exceptions from routing along the tree: destinations that are reached over the link to a "
      "given router.";
  routes.sample_items = R"toml([[route]]
match = "Ladar(3/*)"
via = "robot2"
)toml";
  routes.sample_setting = "route='match=Ladar(3/*),via=robot2'";
  return routes;
}

constexpr List rule_list() {
  List rules = list<&Config::rules>("rule", kRuleOptions);
  rules.help =
      "Who may send what to whom. Without rules, everybody may do everything; users who have "
      "logged "
      "in may do what their rights say, with and without rules.";
  rules.sample_items = R"toml([[rule]]
name = "own programs"
from = "own"
then = "allow"

[[rule]]
name = "guests look"
from = ["user:guest", "net:10.9.0.0/16"]
types = "look"
priority_max = 20
rate = "1MB"
then = "allow"
)toml";
  rules.sample_setting = "rule='name=drivers,from=uid:1000+uid:1001,types=drive+look,then=allow'";
  return rules;
}

constexpr List test_list() {
  List tests = list<&Config::tests>("test", kTestOptions);
  tests.help = "What the rules must say, tested at the start, by --check, and at a reload.";
  tests.sample_items = R"toml([[test]]
name = "a guest does not drive"
from = "user:guest"
to = "Chassis(3/0)"
type = "move"
expect = "deny"
)toml";
  tests.sample_setting =
      "test='name=looks,from=user:guest,to=Chassis(3/0),type=get_status,expect=allow'";
  return tests;
}

constexpr std::array kLists{link_list(), route_list(), rule_list(), test_list()};

// --- output for users: --help and the sample file

constexpr std::string_view kSampleTop =
    "# Configuration of tims-router: every key with its default, commented out.\n"
    "# Sizes (B, KiB, MiB, GiB) and durations (ms, s, min, h) carry units. ${NAME} in a text is\n"
    "# the environment variable. An unknown key is an error. tims-router --help prints the same.\n"
    "# [[link]], [[route]], [[rule]] and [[test]] at the end have no defaults: these are "
    "examples.\n";

std::string default_text(const Option& option) {
  if (!option.default_note.empty()) return std::string(option.default_note);
  Config config;
  for (const List& list : lists()) list.append(config);
  return to_toml(option.get(config));
}

std::string sample_value(const Option& option) {
  return option.sample.empty() ? default_text(option) : std::string(option.sample);
}

// Wraps `text` to lines of at most 98 columns, each prefixed by `margin`, the first by `first`.
std::string wrapped(std::string_view text, std::string_view margin, std::string_view first) {
  constexpr std::size_t kWidth = 98;
  std::string out;
  std::string line(first);
  bool empty = true;
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(' '));
    if (!empty && line.size() + 1 + word.size() > kWidth) {
      out += line + '\n';
      line = margin;
      empty = true;
    }
    line += fmt::format("{}{}", empty ? "" : " ", word);
    empty = false;
    text.remove_prefix(std::min(text.size(), word.size() + 1));
  }
  return out + line + '\n';
}

std::string wrapped(std::string_view text, std::string_view margin) {
  return wrapped(text, margin, margin);
}

std::string full_help(const Option& option) {
  const bool restart = option.reload == Reload::kRestart;
  return fmt::format("{}{}", option.help, restart ? " Changes need a restart." : "");
}

std::string limits_text(const Option& option) {
  const std::string range = range_text(option.kind, option.range);
  return fmt::format("{}{}{}", kind_name(option.kind), range.empty() ? "" : ", ", range);
}

std::string option_help(const Option& option) {
  return fmt::format("  {}  ({}; default {})\n{}", option.key, limits_text(option),
                     default_text(option), wrapped(full_help(option), "      "));
}

std::string sample_option(const Option& option) {
  std::string out = wrapped(fmt::format("{} ({})", full_help(option), limits_text(option)), "# ");
  if (!option.default_note.empty())
    out += wrapped(fmt::format("Default: {}", option.default_note), "# ");
  return out + fmt::format("#{} = {}\n", option.name(), sample_value(option));
}

// The description of an item's keys, then commented examples.
std::string sample_list(const List& list) {
  std::string out = "\n" + wrapped(list.help, "# ");
  for (const Option& option : list.options)
    out += wrapped(
        fmt::format("{} ({}; default {})", option.help, limits_text(option), default_text(option)),
        "#            ", fmt::format("# {:<10} ", option.name()));
  std::string_view items = list.sample_items;
  while (!items.empty()) {
    const std::string_view line = items.substr(0, items.find('\n'));
    out += fmt::format("#{}\n", line);
    items.remove_prefix(line.size() + 1);
  }
  return out;
}

}  // namespace

std::span<const Option> options() { return kOptions; }

const Option* find_option(std::string_view key) {
  const auto found = std::ranges::find(kOptions, key, &Option::key);
  return found == kOptions.end() ? nullptr : &*found;
}

std::vector<Entry> entries(const Config& config) {
  std::vector<Entry> all;
  all.reserve(kOptions.size());
  for (const Option& option : kOptions) all.push_back({std::string(option.key), &option, 0});
  for (const List& list : lists())
    for (std::size_t i = 0; i < list.size(config); ++i)
      for (const Option& option : list.options)
        if (option.has_value(config, i))
          all.push_back({fmt::format("{}.{}", item_key(list, i), option.name()), &option, i});
  return all;
}

const Option* List::find(std::string_view option_name) const {
  const auto found = std::ranges::find(options, option_name, &Option::name);
  return found == options.end() ? nullptr : &*found;
}

std::span<const List> lists() { return kLists; }

const List* find_list(std::string_view name) {
  const auto found = std::ranges::find(kLists, name, &List::name);
  return found == kLists.end() ? nullptr : &*found;
}

std::string item_key(const List& list, std::size_t index) {
  return fmt::format("{}[{}]", list.name, index);
}

std::string options_help() {
  std::string out;
  for (const Option& option : options()) out += option_help(option);
  for (const List& list : lists()) {
    out += fmt::format("\n{}", wrapped(fmt::format("[[{}]] {}", list.name, list.help), "  "));
    out += fmt::format("      --set {}\n", list.sample_setting);
    for (const Option& option : list.options) out += option_help(option);
  }
  return out;
}

std::string sample_file() {
  std::string out(kSampleTop);
  std::string_view table;
  for (const Option& option : options()) {
    if (option.table() != table) {
      table = option.table();
      out += fmt::format("\n[{}]\n", table);
    }
    out += sample_option(option);
  }
  for (const List& list : lists()) out += sample_list(list);
  return out;
}

}  // namespace tims::config
