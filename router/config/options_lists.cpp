// The items of lists: [[link]] and [[route]].
#include <algorithm>
#include <array>

#include <fmt/core.h>

#include "router/config/option_row.h"

namespace tims::config {
namespace {

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

}  // namespace

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

}  // namespace tims::config
