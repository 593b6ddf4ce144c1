#include "router/config/options.h"

#include <algorithm>
#include <array>

#include <fmt/core.h>

#include "router/config/option_row.h"

namespace tims::config {
namespace {

constexpr std::int64_t kSocketPathMax = 107;  // sockaddr_un, with its zero

constexpr std::array kOptions{
    row<Kind::kText, &Config::router, &Config::Router::name>(
        {.key = "router.name",
         .range = {1, 64},
         .reload = Reload::kRestart,
         .help = "Name of this router, for people: it stands in logs, refusals and metrics.",
         .default_note = "the host's name",
         .sample = R"("${HOSTNAME}")"}),
    row<Kind::kRole, &Config::router, &Config::Router::role>(
        {.key = "router.role",
         .reload = Reload::kRestart,
         .help = "Place in the tree of routers: a subsystem router has a super router at most, a "
                 "system router stands for one robot, a top-level router joins robots."}),
    row<Kind::kNumber, &Config::router, &Config::Router::system>(
        {.key = "router.system",
         .range = {0, 255},
         .reload = Reload::kRestart,
         .help = "System (robot) this router belongs to: the first field of its address "
                 "Tims(system/id); 0 for a top-level router."}),
    row<Kind::kNumber, &Config::router, &Config::Router::id>(
        {.key = "router.id",
         .range = {0, 255},
         .reload = Reload::kRestart,
         .help = "Number of this router within its system; no two routers of a system have "
                 "the same."}),
    row<Kind::kNumber, &Config::router, &Config::Router::priority>(
        {.key = "router.priority",
         .range = {0, 99},
         .reload = Reload::kRestart,
         .help =
             "Real-time priority (SCHED_FIFO) of the thread that carries messages, whose memory "
             "is locked then; 0 for none. The original's -P. It needs LimitRTPRIO and "
             "LimitMEMLOCK of a unit, or ulimit -r and -l; without them the router warns and "
             "runs as an ordinary program."}),

    row<Kind::kWidths, &Config::address, &Config::AddressBits::widths>(
        {.key = "address.widths",
         .reload = Reload::kRestart,
         .help = "Bits of each field of an address, 32 in all and at least 1 each; the same for "
                 "every router and component of a fleet."}),

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
         .help = "Where original RACK programs and remote clients connect; \"off\" for "
                 "nowhere, port 0 for any free one. Beyond loopback it needs "
                 "security.insecure. Whoever reaches the port can command every component, on "
                 "loopback every user of this host: where users do not trust each other, write "
                 "\"off\" here and at http.listen, so that unix.path is the only way in."}),
    row<Kind::kFlag, &Config::tcp, &Config::Tcp::admin>(
        {.key = "tcp.admin",
         .reload = Reload::kYes,
         .help = "Lets clients of tcp.listen and http.listen change this router: take links down, "
                 "add routes, spoil links; otherwise only programs that connect to unix.path, and "
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
         .help = "What may wait for one slow TCP client before messages are dropped and "
                 "counted, the least important first."}),

    row<Kind::kEndpoint, &Config::http, &Config::Http::listen>(
        {.key = "http.listen",
         .reload = Reload::kRestart,
         .help = "Where WebSocket clients connect, and /metrics and /healthz are served; "
                 "\"off\" for nowhere. Beyond loopback it needs security.insecure. They can do "
                 "what those of tcp.listen can."}),
    row<Kind::kText, &Config::http, &Config::Http::origins>(
        {.key = "http.origins",
         .range = {0, 1024},
         .reload = Reload::kYes,
         .help = "Web pages that may open a WebSocket here beside those that came from this port: "
                 "\"http://robot7:3000, http://localhost:5173\". The names in them count as names "
                 "of this host."}),

    row<Kind::kEndpoint, &Config::udp, &Config::Udp::listen>(
        {.key = "udp.listen",
         .reload = Reload::kRestart,
         .help = "Where this router speaks with other routers, see [[link]]; \"off\" for nowhere. "
                 "Beyond loopback it needs security.insecure.",
         .default_note = "127.0.0.1:2010, with security.insecure 0.0.0.0:2010",
         .sample = R"("127.0.0.1:2010")"}),

    row<Kind::kText, &Config::fleet, &Config::Fleet::name>(
        {.key = "fleet.name",
         .range = {0, 63},
         .reload = Reload::kRestart,
         .help = "Fleet of this router: routers with the same one find each other by DDS, see "
                 "link.to and link.paths. Routers of other fleets are not seen. Empty: none."}),

    row<Kind::kNumber, &Config::dds, &Config::Dds::domain>(
        {.key = "dds.domain",
         .range = {0, 232},
         .reload = Reload::kRestart,
         .help = "DDS domain of the fleet: its number decides which UDP ports DDS uses."}),
    row<Kind::kFlag, &Config::dds, &Config::Dds::multicast>(
        {.key = "dds.multicast",
         .reload = Reload::kRestart,
         .help = "Looks for routers by multicast; otherwise only at dds.peers and dds.server."}),
    row<Kind::kText, &Config::dds, &Config::Dds::peers>(
        {.key = "dds.peers",
         .range = {0, 1024},
         .reload = Reload::kRestart,
         .help = "Where to look for routers that multicast does not reach: "
                 "\"10.9.1.1, 10.9.1.2:7410\". One side listing the other is enough."}),
    row<Kind::kText, &Config::dds, &Config::Dds::server>(
        {.key = "dds.server",
         .range = {0, 64},
         .reload = Reload::kRestart,
         .help = "A discovery server (timsctl fleet server) that tells who there is, such as "
                 "\"10.9.1.1:11811\"; nobody else is asked then."}),
    row<Kind::kDuration, &Config::dds, &Config::Dds::lease>(
        {.key = "dds.lease",
         .range = {500 * kMs, kHour},
         .reload = Reload::kRestart,
         .help = "After so long without a sign of life a router of the fleet is gone."}),
    row<Kind::kSize, &Config::dds, &Config::Dds::message_max>(
        {.key = "dds.message",
         .range = {512, 65500},
         .reload = Reload::kRestart,
         .help = "Largest datagram of DDS. Beyond what the network takes they go in IP fragments: "
                 "faster where nothing is lost, where some are lost nothing arrives."}),
    row<Kind::kNumber, &Config::dds, &Config::Dds::history>(
        {.key = "dds.history",
         .range = {2, 1024},
         .reload = Reload::kRestart,
         .help = "How many samples of up to 64 KiB one router may leave unacknowledged. What comes "
                 "after them waits, then goes the way of any full queue."}),
    row<Kind::kDuration, &Config::dds, &Config::Dds::heartbeat>(
        {.key = "dds.heartbeat",
         .range = {kMs, 1000 * kMs},
         .reload = Reload::kRestart,
         .help = "How often a router is asked what it has got, as long as it has not acknowledged "
                 "all: so much later is sent again what was lost."}),
    row<Kind::kText, &Config::dds, &Config::Dds::profiles>(
        {.key = "dds.profiles",
         .range = {0, 255},
         .reload = Reload::kRestart,
         .help = "File of XML profiles of Fast DDS; what its participant, data_writer and "
                 "data_reader profiles named \"tims\" say counts."}),

    row<Kind::kSize, &Config::message, &Config::Message::bytes_max>(
        {.key = "message.max",
         .range = {64 * kKi, kGi},
         .reload = Reload::kRestart,
         .help = "Largest message, its 16-byte header included. The original's is 262144B; "
                 "below 64KiB ordinary laser scans would not fit."}),
    row<Kind::kClasses, &Config::message, &Config::Message::classes>(
        {.key = "message.classes",
         .reload = Reload::kRestart,
         .help = "From which priority on a message belongs to class 1, 2, ... 7 of a link; texts "
                 "for people are class 0. 4 to 7 have the reserve of a link's rate, 5 to 7 are "
                 "urgent. The same for all routers of a fleet: a link between others is refused."}),

    row<Kind::kDuration, &Config::lifesign, &Config::Lifesign::interval>(
        {.key = "lifesign.interval",
         .range = {100 * kMs, kHour},
         .reload = Reload::kYes,
         .help =
             "How often a TCP client is asked whether it still lives; one that has not answered "
             "when the next is due is disconnected. Original Java clients leave by themselves "
             "when they hear nothing for 10s."}),

    row<Kind::kNumber, &Config::limits, &Config::Limits::clients>(
        {.key = "limits.clients",
         .range = {1, 16384},
         .reload = Reload::kYes,
         .help =
             "Clients connected at the same time, over all ports. A quarter is kept for programs "
             "of this host; pages of browsers have at most another quarter. While no place is "
             "left for TCP, clients that have not said anything yet make room for new ones."}),
    row<Kind::kNumber, &Config::limits, &Config::Limits::mailboxes_per_client>(
        {.key = "limits.mailboxes_per_client",
         .range = {1, 1048576},
         .reload = Reload::kYes,
         .help = "Mailboxes that one client may have registered."}),

    row<Kind::kLogLevel, &Config::log, &Config::Log::level>(
        {.key = "log.level",
         .reload = Reload::kYes,
         .help = "What is logged: this and everything more serious."}),

    row<Kind::kFlag, &Config::security, &Config::Security::insecure>(
        {.key = "security.insecure",
         .reload = Reload::kRestart,
         .help = "Allows listening beyond loopback although this version has no keys: "
                 "everybody who reaches the port can command the robot. Only for networks "
                 "where every machine is trusted."}),

    row<Kind::kFlag, &Config::sim, &Config::Sim::faults>(
        {.key = "sim.faults",
         .reload = Reload::kYes,
         .help = "Lets timsctl sim fault spoil this router's UDP on purpose; only for tests."}),
};

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

}  // namespace tims::config
