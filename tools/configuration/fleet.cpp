#include "tools/configuration/fleet.h"

#include <algorithm>
#include <map>
#include <numeric>

#include <fmt/format.h>

#include "base/text.h"
#include "rack/proxies/catalogue.h"
#include "tims/message.h"

namespace timsctl::configuration {
namespace {

using tims::config::Config;
using tims::config::Link;
using tims::core::LinkKind;
using tims::core::Role;

// Classes from here on may also use the reserve of a rate (router/link/link_session.cpp).
constexpr std::size_t kUpperClass = 4;
constexpr double kYellow = 0.7;
constexpr double kRed = 1.0;

class Fleet {
 public:
  Fleet(const std::vector<FleetHost>& hosts, const Describe& describe) : hosts_(hosts) {
    for (std::size_t i = 0; i < hosts.size(); ++i) {
      for (const base::TextFile& file : hosts[i].robots) read(file, i, describe);
      parents_.push_back(parent_of(i));
    }
  }

  FleetReport run() {
    check_tree();
    check_widths();
    check_owners();
    check_pilots();
    find_edges();
    order();
    find_budgets();
    return std::move(report_);
  }

 private:
  struct Placed {
    Instance instance;
    std::size_t host = 0;
  };

  void read(const base::TextFile& file, std::size_t host, const Describe& describe) {
    const robot::RobotFile robot = robot::read_robot(file, "robot");
    for (Instance& each : instances_of(file, robot, describe)) {
      // On another computer of the robot, if that is a host of this fleet by its name.
      const auto other = std::ranges::find(hosts_, each.host, &FleetHost::name);
      const bool elsewhere = !each.host.empty() && other != hosts_.end();
      const auto place = elsewhere ? static_cast<std::size_t>(other - hosts_.begin()) : host;
      instances_.push_back({std::move(each), place});
    }
  }

  void find_problem(std::size_t host, const std::string& file, const base::Place& at,
                    std::string text, bool is_error) {
    report_.findings.push_back({.file = file,
                                .line = at.line,
                                .column = at.column,
                                .text = std::move(text),
                                .is_error = is_error,
                                .host = hosts_[host].name});
  }
  void router_problem(std::size_t host, std::string text, bool is_error = true) {
    find_problem(host, "router.toml", {}, std::move(text), is_error);
  }

  // --- the tree of routers

  [[nodiscard]] const Config* router(std::size_t host) const {
    return hosts_[host].router ? &*hosts_[host].router : nullptr;
  }

  [[nodiscard]] std::optional<std::size_t> parent_of(std::size_t host) const {
    const Config* own = router(host);
    if (own == nullptr || own->router.role == Role::kTop) return std::nullopt;
    for (const Link& link : own->links)
      if (link.kind == LinkKind::kSuper)
        if (const auto found = target_of(host, link)) return found;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<std::size_t> target_of(std::size_t host, const Link& link) const {
    std::optional<std::size_t> by_role;
    for (std::size_t i = 0; i < hosts_.size(); ++i) {
      const Config* other = router(i);
      if (i == host || other == nullptr) continue;
      if (is_destination(link, *other)) return i;
      if (!is_above(*other, *router(host))) continue;
      if (link.is_automatic() || (other->udp.listen && other->udp.listen->port == link.port))
        by_role = i;
    }
    return by_role;
  }

  static bool is_destination(const Link& link, const Config& other) {
    if (link.is_automatic() || !other.udp.listen) return false;
    return link.port == other.udp.listen->port &&
           (link.host == other.udp.listen->host || link.host == base::lower(other.router.name));
  }

  static bool is_above(const Config& other, const Config& own) {
    if (own.router.role == Role::kSubsystem)
      return other.router.role == Role::kSystem && other.router.system == own.router.system;
    return other.router.role == Role::kTop;
  }

  void check_tree() {
    std::vector<std::string> tops;
    for (std::size_t i = 0; i < hosts_.size(); ++i)
      if (router(i) != nullptr && router(i)->router.role == Role::kTop)
        tops.push_back(hosts_[i].name);
    const bool several_systems =
        hosts_.size() > 1 && std::ranges::any_of(hosts_, [&](const auto& host) {
          return host.router && hosts_.front().router &&
                 host.router->router.system != hosts_.front().router->router.system;
        });
    for (std::size_t i = 0; i < hosts_.size(); ++i) {
      if (router(i) == nullptr) continue;
      if (router(i)->router.role == Role::kTop && tops.size() > 1)
        router_problem(i, fmt::format("a fleet has one top router, not {}: {}", tops.size(),
                                      fmt::join(tops, ", ")));
      if (tops.empty() && several_systems && router(i)->router.role == Role::kSystem)
        router_problem(i, "no router of these hosts is the top router (router.role = \"top\")",
                       false);
      check_way_up(i);
    }
  }

  void check_way_up(std::size_t host) {
    const Config& own = *router(host);
    const bool needs_one =
        own.router.role == Role::kSubsystem || (own.router.role == Role::kSystem && has_top());
    if (!needs_one || hosts_.size() < 2) return;
    const bool has_link = std::ranges::any_of(
        own.links, [](const Link& link) { return link.kind == LinkKind::kSuper; });
    if (!has_link)
      return router_problem(host,
                            "no way to the super router: a [[link]] of kind \"super\" is missing");
    if (!parents_[host])
      return router_problem(host, "the super router of its links is none of these hosts", false);
    const Config& above = *router(*parents_[host]);
    const bool accepts = std::ranges::any_of(above.links, [&](const Link& link) {
      return link.kind == LinkKind::kSub && link.accepts() &&
             (!link.system || *link.system == own.router.system);
    });
    if (!accepts)
      router_problem(*parents_[host],
                     fmt::format("accepts no sub router of system {}: {} leads here",
                                 own.router.system, hosts_[host].name));
  }

  [[nodiscard]] bool has_top() const {
    return std::ranges::any_of(hosts_, [](const FleetHost& host) {
      return host.router && host.router->router.role == Role::kTop;
    });
  }

  void check_widths() {
    const Config* first = nullptr;
    for (std::size_t i = 0; i < hosts_.size(); ++i) {
      if (router(i) == nullptr) continue;
      if (first == nullptr) first = router(i);
      if (!(router(i)->address == first->address))
        router_problem(i, fmt::format("address.widths differ from those of {}: a fleet has one set",
                                      first->router.name));
    }
  }

  // --- components

  void check_owners() {
    std::map<std::string, const Placed*> owners;
    for (const Placed& each : instances_) {
      const std::string address = each.instance.address();
      if (address.empty()) continue;
      const auto [known, is_new] = owners.emplace(address, &each);
      if (is_new) continue;
      const Placed& other = *known->second;
      find_problem(
          each.host, each.instance.file, each.instance.at,
          fmt::format("{} also runs as {} on {} ({}:{})", address, other.instance.name,
                      hosts_[other.host].name, other.instance.file, other.instance.at.line),
          true);
    }
  }

  // The chassis obeys one pilot; those that are turned on at the start would fight for it.
  void check_pilots() {
    std::map<std::string, const Placed*> pilots;
    for (const Placed& each : instances_) {
      const Instance& pilot = each.instance;
      if (pilot.described == nullptr || pilot.described->class_name != "Pilot" ||
          pilot.value("targetStatus") != "1")
        continue;
      for (const Description::Input& input : pilot.described->inputs) {
        if (input.class_name != "Chassis") continue;
        const std::string chassis = target(pilot, input);
        const auto [known, is_new] = pilots.emplace(chassis, &each);
        if (!is_new)
          find_problem(each.host, pilot.file, pilot.at,
                       fmt::format("{} and {} both drive {} from the start: one pilot a chassis",
                                   known->second->instance.name, pilot.name, chassis),
                       true);
      }
    }
  }

  static std::string target(const Instance& from, const Description::Input& input) {
    const auto number = [&](const std::string& parameter) {
      return base::parse_number<int>(from.value(parameter)).value_or(0);
    };
    const int instance = input.instance.empty() ? 0 : number(input.instance);
    if (instance < 0) return {};
    return fmt::format("{}({}/{})", input.class_name, number(input.system), instance);
  }

  void find_edges() {
    for (const Placed& each : instances_) {
      if (each.instance.described == nullptr) continue;
      for (const Description::Input& input : each.instance.described->inputs)
        find_edge(each, input, target(each.instance, input));
    }
  }

  void find_edge(const Placed& from, const Description::Input& input, const std::string& to) {
    if (to.empty()) return;
    Edge edge{.from = from.instance,
              .to = to,
              .host = hosts_[from.host].name,
              .parameter = input.instance.empty() ? input.system : input.instance};
    const auto found = std::ranges::find(
        instances_, to, [](const Placed& each) { return each.instance.address(); });
    if (found == instances_.end()) {
      const bool is_brought = input.class_name == "Joystick";  // by who drives: the console
      if (!input.optional && !is_brought)
        find_problem(from.host, from.instance.file, from.instance.at,
                     fmt::format("{} uses {}, which no host has", from.instance.name, to), false);
    } else {
      measure(edge, *found);
      flows_.push_back({found->host, from.host, report_.edges.size()});
    }
    report_.edges.push_back(std::move(edge));
  }

  void measure(Edge& edge, const Placed& source) const {
    edge.to_host = hosts_[source.host].name;
    const Instance& instance = source.instance;
    if (instance.described->outputs.empty()) return;
    const Description::Output& output = instance.described->outputs.front();
    const auto period = output.period.empty()
                            ? std::nullopt
                            : base::parse_number<double>(instance.value(output.period));
    edge.period_ms = period.value_or(output.default_ms);
    const rack::MessageInfo* data =
        rack::find_message(instance.described->class_id, tims::type::kData);
    if (data != nullptr && data->body != nullptr)
      edge.bytes_max = data->body->size_max + tims::kHeaderSize;
    const Config* config = router(source.host);
    const auto priority = base::parse_number<std::uint8_t>(instance.value("dataTaskPrio"));
    if (config != nullptr) edge.message_class = config->message.classes.of(priority.value_or(0));
  }

  // --- order and budgets

  void order() {
    std::vector<std::size_t> all(hosts_.size());
    std::iota(all.begin(), all.end(), 0U);
    // Levels of the tree are roles. A change may just be cutting the link that would show them.
    std::ranges::stable_sort(all, {}, [&](std::size_t host) {
      return router(host) == nullptr ? Role::kSubsystem : router(host)->router.role;
    });
    for (const std::size_t host : all) report_.order.push_back(hosts_[host].name);
  }

  void find_budgets() {
    for (std::size_t i = 0; i < hosts_.size(); ++i) {
      if (!parents_[i]) continue;
      add_budget(i, *parents_[i], LinkKind::kSuper);
      add_budget(*parents_[i], i, LinkKind::kSub);
    }
    for (const Flow& flow : flows_) {
      const Edge& edge = report_.edges[flow.edge];
      if (edge.period_ms <= 0) continue;
      const double bytes = static_cast<double>(edge.bytes_max) * 1000 / edge.period_ms;
      for (const auto& [from, to] : way(flow.from, flow.to))
        budget(from, to).worst.at(edge.message_class) += bytes;
    }
  }

  void add_budget(std::size_t from, std::size_t to, LinkKind kind) {
    LinkBudget made{.host = hosts_[from].name, .other = router(to)->router.name};
    for (const Link& link : router(from)->links) {
      const bool fits =
          link.kind == kind &&
          (kind == LinkKind::kSuper ? target_of(from, link) == to
                                    : !link.system || *link.system == router(to)->router.system);
      if (!fits) continue;
      made.rate = link.rate;
      made.reserve_percent = link.reserve;
      break;
    }
    places_[{from, to}] = report_.links.size();
    report_.links.push_back(made);
  }

  LinkBudget& budget(std::size_t from, std::size_t to) {
    return report_.links[places_.at({from, to})];
  }

  // Up to the common router, then down.
  [[nodiscard]] std::vector<std::pair<std::size_t, std::size_t>> way(std::size_t from,
                                                                     std::size_t to) const {
    const auto up = [&](std::size_t host) {
      std::vector<std::size_t> all{host};
      while (parents_[all.back()] && all.size() <= hosts_.size())
        all.push_back(*parents_[all.back()]);
      return all;
    };
    const std::vector<std::size_t> a = up(from);
    const std::vector<std::size_t> b = up(to);
    const auto meeting = std::ranges::find_if(
        a, [&](std::size_t host) { return std::ranges::find(b, host) != b.end(); });
    std::vector<std::pair<std::size_t, std::size_t>> hops;
    if (meeting == a.end()) return hops;
    for (auto at = a.begin(); at != meeting; ++at) hops.emplace_back(*at, *std::next(at));
    const auto end = static_cast<std::size_t>(std::ranges::find(b, *meeting) - b.begin());
    for (std::size_t i = end; i > 0; --i) hops.emplace_back(b[i], b[i - 1]);
    return hops;
  }

  struct Flow {
    std::size_t from = 0;
    std::size_t to = 0;
    std::size_t edge = 0;
  };

  const std::vector<FleetHost>& hosts_;
  std::vector<Placed> instances_;
  std::vector<std::optional<std::size_t>> parents_;
  std::vector<Flow> flows_;
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> places_;
  FleetReport report_;
};

}  // namespace

double LinkBudget::worst_sum() const { return std::accumulate(worst.begin(), worst.end(), 0.0); }

double LinkBudget::share(double lower, double all) const {
  if (rate == 0) return 0;
  const double cap = static_cast<double>(rate);
  return std::max(all / cap, lower / (cap * (100 - reserve_percent) / 100));
}

double LinkBudget::worst_share() const {
  return share(std::accumulate(worst.begin(), worst.begin() + kUpperClass, 0.0), worst_sum());
}

double LinkBudget::measured_share() const { return share(0, measured.value_or(0)); }

std::string_view LinkBudget::level() const {
  const double most = std::max(worst_share(), measured_share());
  return most >= kRed ? "red" : most >= kYellow ? "yellow" : "ok";
}

FleetReport check_fleet(const std::vector<FleetHost>& hosts, const Describe& describe) {
  return Fleet(hosts, describe).run();
}

}  // namespace timsctl::configuration
