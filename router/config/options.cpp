#include "router/config/options.h"

#include <algorithm>
#include <array>

#include <fmt/core.h>

namespace tims::config {
namespace {

constexpr std::int64_t kKi = 1LL << 10;
constexpr std::int64_t kGi = 1LL << 30;
constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kHour = 3'600'000 * kMs;
constexpr std::int64_t kSocketPathMax = 107;  // sockaddr_un, with its zero

// How a member of Config is kept in a Value, and back.
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

// The struct that holds the member: a table of Config, or one item of a list of Config.
template <auto holder, typename AnyConfig>
auto& held(AnyConfig& config, [[maybe_unused]] std::size_t index) {
  if constexpr (requires { (config.*holder).at(index); })
    return (config.*holder).at(index);
  else
    return config.*holder;
}

// A row: the way to the value, then what is said about it.
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
                 "security.insecure."}),
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
                 "\"off\" for nowhere. Beyond loopback it needs security.insecure."}),

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
         .help = "Clients connected at the same time, over all ports."}),
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

// Where a link connects is one key and two members.
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

constexpr std::array kLinkOptions{
    row<Kind::kLinkKind, &Config::links, &Link::kind>(
        {.key = "link.kind",
         .help = "What the other router is to this one: its super router (a second super link is "
                 "the next in order of preference), a peer, or a router below it.",
         .default_note = "none: it must be written"}),
    destination_row({.key = "link.to",
                     .help = "Where this side connects; without a port 2010. Beyond loopback it "
                             "needs security.insecure. \"auto\" finds the super router in the "
                             "fleet, by role and system. A super link needs it, a sub link has "
                             "none, a peer link without it accepts.",
                     .default_note = "none: this side accepts"}),
    accepted_system_row({.key = "link.system",
                         .help = "Whom this side accepts: routers of this system, \"*\" for any. "
                                 "Only where it accepts."}),
    row<Kind::kPaths, &Config::links, &Link::paths>(
        {.key = "link.paths",
         .help = "Ways to the other router in order of preference: \"udp\", \"dds\". A later one "
                 "carries the link while those before do not work; dds wants fleet.name.",
         .default_note = "[\"udp\"], with fleet.name [\"udp\", \"dds\"]",
         .sample = R"(["udp", "dds"])"}),
    row<Kind::kText, &Config::links, &Link::name>(
        {.key = "link.name", .range = {0, 64}, .help = "Label of the link, for people."}),
    row<Kind::kDuration, &Config::links, &Link::interval>(
        {.key = "link.interval",
         .range = {50 * kMs, 10'000 * kMs},
         .help = "How often the link shows that it lives; after three missed it is dead."}),
    row<Kind::kRate, &Config::links, &Link::rate>(
        {.key = "link.rate",
         .range = {10'000, 100'000'000'000},
         .help = "Bytes a second this router sends at most; 0 for no cap."}),
    row<Kind::kNumber, &Config::links, &Link::reserve>(
        {.key = "link.reserve",
         .range = {0, 90},
         .help = "Percent of the rate that is kept for the upper classes of priority."}),
    row<Kind::kDuration, &Config::links, &Link::lifetime>(
        {.key = "link.lifetime",
         .range = {100 * kMs, kHour},
         .help = "How long a reliable message is tried before it is given up and counted."}),
};

constexpr std::array kRouteOptions{
    row<Kind::kText, &Config::routes, &Route::match>(
        {.key = "route.match",
         .range = {1, 64},
         .help = "Which destinations: an address pattern such as \"Ladar(3/*)\".",
         .default_note = "none: it must be written"}),
    row<Kind::kText, &Config::routes, &Route::via>(
        {.key = "route.via",
         .range = {1, 64},
         .help = "Name (router.name) of the router at the other end of a link.",
         .default_note = "none: it must be written"}),
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

[[link]]                        # where to turn when the first is not there
kind = "super"
to = "fleet.example.org"
rate = "6MB"

[[link]]                        # by the name of the fleet, see [fleet]
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
  routes.help = "What goes another way than the tree's, over the link to a certain router.";
  routes.sample_items = R"toml([[route]]
match = "Ladar(3/*)"
via = "robot2"
)toml";
  routes.sample_setting = "route='match=Ladar(3/*),via=robot2'";
  return routes;
}

constexpr std::array kLists{link_list(), route_list()};

}  // namespace

std::span<const Option> options() { return kOptions; }

const Option* find_option(std::string_view key) {
  const auto found = std::ranges::find(kOptions, key, &Option::key);
  return found == kOptions.end() ? nullptr : &*found;
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

std::vector<Entry> entries(const Config& config) {
  std::vector<Entry> all;
  all.reserve(kOptions.size());
  for (const Option& option : kOptions) all.push_back({std::string(option.key), &option, 0});
  for (const List& list : kLists)
    for (std::size_t i = 0; i < list.size(config); ++i)
      for (const Option& option : list.options)
        if (option.has_value(config, i))
          all.push_back({fmt::format("{}.{}", item_key(list, i), option.name()), &option, i});
  return all;
}

}  // namespace tims::config
