#include "router/config/options.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include <fmt/core.h>

namespace tims::config {
namespace {

// --- how a row of the table reaches its member of Config

constexpr std::int64_t kKi = 1LL << 10;
constexpr std::int64_t kGi = 1LL << 30;
constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kHour = 3'600'000 * kMs;

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

// --- the options

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
         .help = "Lets timsctl sim fault make this router lose and delay UDP on purpose; only for "
                 "tests."}),
};

// --- the items of lists: [[link]] and [[route]]

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
         .default_note = R"(["udp"], with fleet.name ["udp", "dds"])",
         .sample = R"(["udp", "dds"])"}),
    row<Kind::kText, &Config::links, &Link::name>(
        {.key = "link.name", .range = {0, 64}, .help = "Label of the link, for people."}),
    row<Kind::kNumber, &Config::links, &Link::mailboxes>(
        {.key = "link.mailboxes",
         .range = {1, 1048576},
         .help = "Mailboxes that the other router may announce over this link; what is beyond is "
                 "not taken, and said in the log. A link for one system (link.system) brings only "
                 "mailboxes and messages of that system."}),
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

// --- what people read: --help and the sample file

constexpr std::string_view kSampleTop =
    "# Configuration of tims-router: every key with its default, switched off by a '#'.\n"
    "# Sizes (B, KiB, MiB, GiB) and durations (ms, s, min, h) carry units. ${NAME} in a text is\n"
    "# the environment variable. An unknown key is an error. tims-router --help says the same.\n"
    "# [[link]] and [[route]] at the end have no defaults: what stands there are examples.\n";

std::string default_text(const Option& option) {
  if (!option.default_note.empty()) return std::string(option.default_note);
  Config config;
  for (const List& list : lists()) list.append(config);
  return to_toml(option.get(config));
}

std::string sample_value(const Option& option) {
  return option.sample.empty() ? default_text(option) : std::string(option.sample);
}

// `text` in lines of at most 98 columns, each behind `margin`, the first behind `first`.
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

// The keys of an item in words, then examples behind '#'.
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
