#include <algorithm>
#include <bit>

#include <fmt/format.h>

#include "router/config/load.h"
#include "router/config/networks.h"
#include "router/config/options.h"
#include "router/core/newest_values.h"
#include "router/policy/lifetimes.h"

namespace tims::config {
namespace {

constexpr std::string_view kInsecure =
    "where every machine of the network is trusted, write \"insecure = true\" under [security] (or "
    "--set security.insecure=true)";
constexpr std::string_view kNoKeys =
    "is not a loopback address, and this router has no keys: any program that can reach the port "
    "could command the robot";

constexpr std::string_view kFastDds = TIMS_FAST_DDS_VERSION;

// The branch 2.9 ended in 2023; faults that were found later are mended in other branches only.
constexpr std::string_view faults_of(std::string_view fast_dds) {
  return fast_dds.starts_with("2.9.")
             ? "whoever sends it datagrams may overflow its memory (CVE-2025-62799, "
               "CVE-2024-30259) or exhaust it (CVE-2025-64438), which nobody mends in this version"
             : "see the advisories of eProsima/Fast-DDS for this version";
}

bool fits(std::uint32_t value, std::uint8_t bits) { return std::bit_width(value) <= bits; }

class Checker {
 public:
  Checker(const Config& config, const Written& written) : config_(config), written_(written) {}

  std::vector<Problem> run() {
    check_plain();
    check_http_files();
    if (!has_keys()) {
      check_exposure("tcp.listen", config_.tcp.listen);
      check_exposure("http.listen", config_.http.listen);
      check_exposure("udp.listen", config_.udp.listen);
    }
    check_age_of_list();
    check_names();
    check_origins();
    check_newest();
    check_lifetimes();
    check_router();
    check_fleet();
    for (std::size_t i = 0; i < config_.links.size(); ++i) check_link(i);
    check_links();
    for (std::size_t i = 0; i < config_.routes.size(); ++i) check_route(i);
    check_policy();
    return std::move(problems_);
  }

 private:
  // --- the router

  void check_exposure(std::string_view key, const std::optional<Endpoint>& listen) {
    if (!listen || listen->loopback() || is_insecure()) return;
    fail(key,
         fmt::format("{} \"{}\" {}. Make keys (timsctl key init, or timsctl join TEXT) and write "
                     "their folder, keys = \"/etc/tims/keys\", under [security]; or listen on "
                     "\"127.0.0.1:{}\"; or, {}",
                     key, listen->to_string(), kNoKeys, listen->port, kInsecure));
  }

  void check_plain() {
    if (const auto networks = Networks::parse(config_.tcp.plain); !networks)
      fail("tcp.plain", "tcp.plain: " + networks.error().detail());
  }

  void check_http_files() {
    if (config_.http.certificate.empty() != config_.http.key.empty())
      fail(config_.http.key.empty() ? "http.certificate" : "http.key",
           "http.certificate and http.key belong together: give both or none");
    else if (!config_.http.key.empty() && config_.security.keys.empty())
      fail("http.certificate",
           "http.certificate without security.keys: HTTPS needs keys of the fleet for logins, see "
           "timsctl key init");
  }

  void check_names() {
    for (const std::string& name : list_of(config_.http.names)) {
      const bool is_plain = std::ranges::all_of(name, [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               c == '-' || c == '.' || c == '_';
      });
      if (is_plain) continue;
      fail("http.names", fmt::format("http.names: {} is not the name of a host: write "
                                     "\"robot7.local\", without http:// and without a port",
                                     in_quotes(name)));
    }
  }

  void check_origins() {
    for (const std::string& origin : list_of(config_.http.origins)) {
      const std::size_t scheme = origin.starts_with("https://")  ? 8
                                 : origin.starts_with("http://") ? 7
                                                                 : std::string::npos;
      const bool has_host = scheme < origin.size();
      if (has_host && origin.find_first_of("/@?#* ", scheme) == std::string::npos) continue;
      fail("http.origins",
           fmt::format("http.origins: \"{}\" is not the origin of a web page: write "
                       "\"http://robot7:3000\", with nothing after the port",
                       origin));
    }
  }

  void check_newest() {
    core::NewestRule rule;
    for (const std::string& stream : list_of(config_.newest.streams))
      if (!rule.add(stream))
        fail("newest.streams", fmt::format("newest.streams: {} is none of \"status\", "
                                           "\"parameters\", \"state\" and \"*\", nor "
                                           "the name of a class such as Position",
                                           in_quotes(stream)));
  }

  void check_age_of_list() {
    const Config::Security& security = config_.security;
    if (security.refuse_old_list && security.list_age_max == Duration::zero())
      fail("security.refuse_old_list",
           "security.refuse_old_list: no list is old without security.list_age_max: set it to "
           "several days, as in list_age_max = \"72h\"");
  }

  void check_lifetimes() {
    policy::Lifetimes lifetimes;
    for (const std::string& lifetime : list_of(config_.message.lifetimes))
      if (!lifetimes.add(lifetime))
        fail("message.lifetimes",
             fmt::format("message.lifetimes: {} is no type of commands and its time, or there are "
                         "more than {}: write \"chassis.move 150ms\"",
                         in_quotes(lifetime), policy::Lifetimes::kMost));
  }

  void check_router() {
    const AddressWidths& widths = config_.address.widths;
    check_width("router.system", config_.router.system, "system", widths.system);
    check_width("router.id", config_.router.id, "instance", widths.instance);
    if (config_.router.role == Role::kTop && config_.router.system != 0)
      fail("router.system",
           fmt::format("router.system {} does not fit role = \"top\": a top-level router belongs "
                       "to no system. Write system = 0, or role = \"system\"",
                       config_.router.system));
  }

  void check_width(std::string_view key, std::uint32_t value, std::string_view field,
                   std::uint8_t bits) {
    if (!fits(value, bits)) fail(key, does_not_fit(key, value, field, bits));
  }

  static std::string does_not_fit(std::string_view key, std::uint32_t value, std::string_view field,
                                  std::uint8_t bits) {
    return fmt::format(
        "{} {} does not fit into the {} bits of {} of address.widths: write at most {}, or wider "
        "fields for the whole fleet, such as widths = \"12/8/6/6\" under [address]",
        key, value, bits, field, (std::uint64_t{1} << bits) - 1);
  }

  // --- one link

  void check_link(std::size_t i) {
    const Link& link = config_.links[i];
    if (link.system) {
      const std::uint8_t bits = config_.address.widths.system;
      if (!fits(*link.system, bits))
        fail(key(i, "system"), does_not_fit("link.system", *link.system, "system", bits));
    }
    check_paths(i, link);
    if (has(i, "secure") && link.secure && !has_keys())
      fail(key(i, "secure"),
           "link.secure = true needs keys: make them by timsctl key init or timsctl join, and name "
           "their folder, keys = \"/etc/tims/keys\" under [security]");
    if (!has(i, "kind")) {
      if (is_complete(i))
        fail(item(i), R"(a link needs a kind: write kind = "super", "peer" or "sub")");
    } else if (written_.origins.contains(key(i, "kind"))) {
      check_direction(i, link);
      check_role(i, link.kind);
    }
  }

  [[nodiscard]] bool has_keys() const { return !config_.security.keys.empty(); }

  // True when listening beyond loopback is allowed, or the option for it was given with a bad
  // value.
  [[nodiscard]] bool is_insecure() const {
    return config_.security.insecure || written_.refused.contains("security.insecure");
  }

  void check_reach(std::size_t i, const Link& link) {
    if (link.accepts() || link.is_automatic() || is_insecure() || has_keys() ||
        Destination{link.host, link.port}.loopback())
      return;
    fail(key(i, "to"),
         fmt::format(
             "link.to \"{}\" {}, because udp.listen would have to be beyond loopback too. Link "
             "to \"127.0.0.1:{}\"; or, {}",
             link.to_string(), kNoKeys, link.port, kInsecure));
  }

  // Checks which side connects and which accepts.
  void check_direction(std::size_t i, const Link& link) {
    const bool has_to = has(i, "to");
    if (link.kind == LinkKind::kSub && has_to)
      return fail(key(i, "to"),
                  "link.to does not fit kind = \"sub\": the routers below connect, "
                  "and this side accepts. Remove it, or write kind = \"super\"");
    check_reach(i, link);
    if (link.kind == LinkKind::kSuper && !has_to && is_complete(i))
      fail(item(i),
           "a super link needs the super router's host and port: write "
           "to = \"10.9.1.1:2010\"");
    if (has(i, "system") && (has_to || link.kind == LinkKind::kSuper))
      fail(key(i, "system"),
           "link.system selects the routers this side accepts, but on this link it "
           "connects: remove it");
  }

  void check_role(std::size_t i, LinkKind kind) {
    if (written_.refused.contains("router.role")) return;
    const Role role = config_.router.role;
    if (role == Role::kTop && kind == LinkKind::kSuper)
      fail(key(i, "kind"),
           "a router with role = \"top\" has no super router: remove the link, or "
           "write role = \"system\" under [router]");
    if (role == Role::kSubsystem && kind != LinkKind::kSuper)
      fail(key(i, "kind"),
           fmt::format("a router with role = \"subsystem\" has super links only, not {}: remove "
                       "the link, or write role = \"system\" under [router]",
                       to_toml(kind)));
  }

  void check_paths(std::size_t i, const Link& link) {
    const bool by_name = !config_.fleet.name.empty() || written_.refused.contains("fleet.name");
    if (link.is_automatic() && link.kind != LinkKind::kSuper)
      fail(key(i, "to"),
           "link.to \"auto\" finds super routers only: write the other router's host "
           "and port, or kind = \"super\"");
    if (link.is_automatic() && !by_name)
      fail(key(i, "to"),
           R"(link.to "auto" needs the name of the fleet: write name = "..." under [fleet])");
    if (link.uses(PathKind::kDds) && !by_name)
      fail(
          key(i, "paths"),
          R"(link.paths with "dds" needs the name of the fleet: write name = "..." under [fleet])");
    if (link.uses(PathKind::kDds)) check_dds(key(i, "paths"), "link.paths with \"dds\"");
    check_is_found(i, link);
  }

  // `to` is an address of UDP and TCP. Without both, a single super link finds the router above by
  // its role; all other links find no router.
  void check_is_found(std::size_t i, const Link& link) {
    const bool has_address = link.uses(PathKind::kUdp) || link.uses(PathKind::kTcp);
    if (link.accepts() || link.is_automatic() || has_address) return;
    const bool only_super = link.kind == LinkKind::kSuper &&
                            std::ranges::count(config_.links, LinkKind::kSuper, &Link::kind) == 1;
    if (only_super) return;
    fail(key(i, "paths"),
         fmt::format(R"(link.paths with "dds" alone cannot reach {}, which is a UDP address: )"
                     R"(write paths = ["udp", "dds"])",
                     in_quotes(link.to_string())));
  }

  // --- the fleet

  void check_dds(const std::string& key, std::string_view what) {
    if (!kHasDds)
      fail(key, fmt::format("{} needs DDS, but this router was built without it "
                            "(TIMS_WITH_DDS=OFF): remove it, or install a router with DDS",
                            what));
  }

  void check_fleet() {
    if (config_.dds.beyond_host && !has_keys() && !is_insecure())
      fail("dds.beyond_host",
           fmt::format("dds.beyond_host = true without keys: any program in the network could "
                       "command the robot. Make keys (timsctl key init, or timsctl join TEXT) and "
                       "write their folder under [security]; or, {}",
                       kInsecure));
    if (!config_.fleet.name.empty()) check_dds("fleet.name", "fleet.name");
    for (const std::string& peer : list_of(config_.dds.peers))
      if (!is_place(peer))
        fail("dds.peers", fmt::format("dds.peers must be numeric addresses such as \"10.9.1.1, "
                                      "10.9.1.2:7410\", not {}",
                                      in_quotes(peer)));
    const std::string& server = config_.dds.server;
    if (!server.empty() && !Endpoint::parse(server))
      fail("dds.server", fmt::format("dds.server must be a numeric address and port such as "
                                     "\"10.9.1.1:11811\", not {}",
                                     in_quotes(server)));
  }

  // True for "10.9.1.1" and "10.9.1.1:7410".
  static bool is_place(const std::string& text) {
    return Endpoint::parse(text) || Endpoint::parse(text + ":1");
  }

  // --- all links

  void check_links() {
    // Routers connect by TCP at the same address.
    const bool some_udp = std::ranges::any_of(config_.links, [](const Link& link) {
      return link.uses(PathKind::kUdp) || (link.uses(PathKind::kTcp) && link.accepts());
    });
    if (some_udp && !config_.udp.listen)
      fail("udp.listen",
           fmt::format(
               "udp.listen \"off\" leaves nothing for the {} to run over, "
               "the first of {}: write listen = \"0.0.0.0:2010\" under "
               "[udp], or remove them",
               config_.links.size() == 1 ? "link" : fmt::format("{} links", config_.links.size()),
               origin(item(0)).to_string()));
    for (std::size_t i = 0; i < config_.links.size(); ++i)
      for (std::size_t before = 0; before < i; ++before)
        if (is_same(before, i)) {
          const bool accepts = config_.links[i].accepts();
          fail(accepts ? item(i) : key(i, "to"),
               fmt::format("link {} is already configured at {}: remove one of them",
                           in_quotes(config_.links[i].to_string()),
                           origin(item(before)).to_string()));
          break;
        }
  }

  // To the same router, or for the same group of routers: one of both would never be used.
  [[nodiscard]] bool is_same(std::size_t before, std::size_t i) const {
    const Link& a = config_.links[before];
    const Link& b = config_.links[i];
    if (!a.accepts() || !b.accepts()) return a.host == b.host && a.port == b.port;
    const bool both_read = is_sound(before) && is_sound(i);
    const bool none_connects = a.kind != LinkKind::kSuper;  // already reported
    return both_read && none_connects && a.kind == b.kind && a.system == b.system;
  }

  // --- routes

  void check_route(std::size_t i) {
    const Route& route = config_.routes[i];
    const std::string item = fmt::format("route[{}]", i);
    const bool complete = !written_.refused.contains(item);
    for (const std::string_view name : {"match", "via"})
      if (complete && !has(fmt::format("{}.{}", item, name)))
        fail(item, fmt::format("a route needs {0}: write {0} = {1}", name,
                               name == "match" ? "\"Ladar(3/*)\""
                                               : "\"robot2\", the name of the "
                                                 "router to go through"));
    const bool read = written_.origins.contains(item + ".match");
    const bool widths_known = !written_.refused.contains("address.widths");
    if (read && widths_known && !AddressPattern::parse(route.match, config_.address.widths))
      fail(item + ".match", fmt::format("route.match must be an address pattern such as "
                                        "\"Ladar(3/*)\", \"*(2/*)\" or \"0x03140000\", not {}",
                                        in_quotes(route.match)));
    const auto first = std::ranges::find(config_.routes, route);
    const auto before = static_cast<std::size_t>(first - config_.routes.begin());
    if (read && before != i)
      fail(item, fmt::format("the same route is already configured at {}: remove one of them",
                             origin(fmt::format("route[{}]", before)).to_string()));
  }

  // --- rules and their tests

  void check_policy() {
    for (const auto& [key, at] : written_.refused)
      if (key.starts_with("rule[") || key.starts_with("test[") || key == "address.widths") return;
    std::vector<policy::Problem> problems;
    (void)policy::Policy::compile(policy_text(config_, rule_places(written_.origins)),
                                  config_.address.widths, problems);
    for (policy::Problem& problem : problems) {
      const std::string item =
          fmt::format("{}[{}]", problem.is_test ? "test" : "rule", problem.index);
      const std::string key = fmt::format("{}.{}", item, problem.key);
      fail(has(key) ? key : item, std::move(problem.text));
    }
  }

  // --- positions in the configuration

  static std::string item(std::size_t i) { return fmt::format("link[{}]", i); }
  static std::string key(std::size_t i, std::string_view name) {
    return fmt::format("link[{}].{}", i, name);
  }
  [[nodiscard]] bool has(std::string_view key) const {
    return written_.origins.contains(key) || written_.refused.contains(key);
  }
  [[nodiscard]] bool has(std::size_t i, std::string_view name) const { return has(key(i, name)); }
  // True when no key was mistyped: a missing key was really omitted.
  [[nodiscard]] bool is_complete(std::size_t i) const {
    return !written_.refused.contains(item(i));
  }
  // True when the item has no refused values.
  [[nodiscard]] bool is_sound(std::size_t i) const {
    const auto next = written_.refused.lower_bound(item(i));
    return (next == written_.refused.end() || !next->first.starts_with(item(i))) && has(i, "kind");
  }
  [[nodiscard]] Origin origin(std::string_view key) const {
    for (const Origins* places : {&written_.origins, &written_.refused})
      if (const auto found = places->find(key); found != places->end()) return found->second;
    return {};
  }
  void fail(std::string_view key, std::string text) {
    problems_.push_back({origin(key), std::move(text)});
  }

  const Config& config_;
  const Written& written_;
  std::vector<Problem> problems_;
};

}  // namespace

std::vector<Problem> check(const Config& config, const Written& written) {
  return Checker(config, written).run();
}

std::vector<std::string> cautions(const Config& config) {
  std::vector<std::string> texts;
  if (kHasDds && !config.fleet.name.empty() && config.dds_leaves_host())
    texts.push_back(fmt::format(
        "DDS is open to the network, and so is its library, Fast DDS {}: {}. It runs without keys "
        "and rights (tims-router-dds), and links over it are sealed if the router has keys; "
        "{}, or fleet.name = \"\", closes it",
        kFastDds, faults_of(kFastDds),
        config.has_keys() ? "dds.beyond_host = false" : "security.insecure = false"));
  return texts;
}

}  // namespace tims::config
