#include "router/io/admin_actions.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/text.h"
#include "router/io/admin_answers.h"

namespace tims::io {
namespace {

using link::Links;

namespace json = boost::json;

Links::Action action_of(std::string_view action) {
  if (action == "up") return Links::Action::kUp;
  return action == "down" ? Links::Action::kDown : Links::Action::kReset;
}

// Names of the routers at the other ends. With `places`, a router whose name is unknown is
// represented by its configured address.
std::vector<std::string_view> link_names(const AdminSource& source, bool places) {
  std::vector<std::string_view> names;
  if (const Links* links = source.links())
    links->for_each([&](const link::Link& link) {
      const std::string_view name = link.peer().name.view();
      if (places || !name.empty()) names.push_back(name.empty() ? link.settings().to : name);
    });
  return names;
}

// A route over a link that does not exist would silently drop messages.
std::optional<QuestionError> no_link_for_route(const AdminSource& source, std::string_view name) {
  const auto known = link_names(source, false);
  if (std::ranges::find(known, name) != known.end()) return std::nullopt;
  std::string hint = "this router has no links: [[link]] in its configuration";
  if (const auto near = base::nearest(name, known))
    hint = fmt::format("did you mean {}?", *near);
  else if (!known.empty())
    hint = fmt::format("there are {}", fmt::join(known, ", "));
  return QuestionError{"no_such_link", fmt::format("no link to a router \"{}\"", name), hint};
}

QuestionError not_done(std::string why) { return {"not_done", std::move(why)}; }

QuestionError no_link(const AdminSource& source, std::string_view name) {
  const auto known = link_names(source, true);
  return not_done(known.empty() ? fmt::format("no link to \"{}\"; there are none", name)
                                : fmt::format("no link to \"{}\"; there are links to {}", name,
                                              fmt::join(known, ", ")));
}

std::optional<QuestionError> change_routes(const Question& question, AdminSource& source) {
  std::vector<core::StaticRoute> routes = source.router().routes().all_static();
  const std::size_t gone = std::erase_if(routes, [&](const core::StaticRoute& route) {
    return route.text.view() == question.pattern &&
           (question.link.empty() || route.via.view() == question.link);
  });
  if (question.ask == Ask::kRouteAdd) {
    if (question.link.empty())
      return not_done("\"via\" is missing: the name of a router on a link");
    if (auto wrong = no_link_for_route(source, question.link)) return wrong;
    if (routes.size() >= kStaticRoutesMax)
      return not_done("there are " + std::to_string(kStaticRoutesMax) + " static routes already");
    routes.push_back(
        {question.match, std::string_view(question.pattern), std::string_view(question.link)});
  } else if (gone == 0) {
    return not_done("no static route for \"" + question.pattern + "\"");
  }
  source.set_static_routes(routes);
  return std::nullopt;
}

// Executes the question's request; returns the error if it fails.
std::optional<QuestionError> carry_out(const Question& question, AdminSource& source) {
  switch (question.ask) {
    case Ask::kLinkDo:
      if (source.act_on_link(question.link, action_of(question.action))) return std::nullopt;
      return no_link(source, question.link);
    case Ask::kFault:
      if (!source.config().sim.faults)
        return not_done(
            "this router injects no faults: set sim.faults = true in its configuration and "
            "reload it");
      if (source.inject_faults(question.link, question.faults)) return std::nullopt;
      return no_link(source, question.link);
    default:
      return change_routes(question, source);
  }
}

// "link robot3 down", "route_add Ladar(3/*) robot3", "fault"
std::string change_text(const Question& question) {
  std::string text(name(question.ask));
  for (const std::string* part : {&question.pattern, &question.link, &question.action})
    if (!part->empty()) text.append(" ").append(*part);
  return text;
}

// Whom the asker may let log in: himself.
std::optional<Person> person_asking(core::ClientId asker, const AdminSource& source) {
  const core::Client* client = source.router().client(asker);
  if (client == nullptr) return std::nullopt;
  if (const Person* person = source.person(client->info.port, client->info.token)) return *person;
  if (client->info.port != core::PortKind::kLocal) return std::nullopt;
  // With unix.everybody, other users may look.
  const bool is_trusted = !source.config().unix.everybody || client->info.uid == 0 ||
                          client->info.uid == source.process({}).uid;
  policy::Subject proven = client->info.subject;
  std::erase(proven.identities, "port:local");
  return Person{.name = fmt::format("uid {}", client->info.uid),
                .rights = rights_up_to(is_trusted ? Right::kConfigure : Right::kLook),
                .proven = std::move(proven)};
}

// A subsystem router has the leases of the router above it, and gives none.
std::optional<QuestionError> lease_elsewhere(const Question& question, core::ClientId asker,
                                             const core::Router& router) {
  const core::Client* above = router.client(router.routes().uplink());
  const bool is_below = router.settings().role == core::Role::kSubsystem && above != nullptr &&
                        above->info.link.role == core::Role::kSystem;
  if (is_below && asker != above->id)
    return QuestionError{
        "lease_elsewhere", "the router above this one has the driving leases of its robot",
        fmt::format("ask {}", above->info.link.router.to_string(router.settings().widths))};
  if (question.mailbox && !is_below)
    return QuestionError{"bad_argument", "\"mailbox\" is for the router above a subsystem router"};
  return std::nullopt;
}

bool has(const std::vector<core::StaticRoute>& routes, const core::StaticRoute& route) {
  return std::ranges::any_of(routes, [&](const core::StaticRoute& other) {
    return other.text.view() == route.text.view() && other.via.view() == route.via.view();
  });
}

}  // namespace

std::string act(const Question& question, core::ClientId asker, AdminSource& source,
                const Clocks& clocks) {
  if (const auto problem = carry_out(question, source)) return error_text(*problem);
  source.changed(clocks.now, asker, change_text(question));
  json::object out = answer_frame(source, clocks, "tims/done/1");
  out["done"] = true;
  return json::serialize(out);
}

std::string make_login(const Question& question, core::ClientId asker, AdminSource& source,
                       const Clocks& clocks) {
  auto person = person_asking(asker, source);
  const Right wanted = right_of(question.right).value_or(Right::kNone);
  if (!person || !has(person->rights, std::max(wanted, Right::kLook)))
    return error_text(
        {"denied",
         "a login is given to programs of the router's host, and to users of the fleet "
         "for the rights they have",
         "run timsctl web on the router's host"});
  if (wanted != Right::kNone) person->rights = rights_up_to(wanted);
  const std::string right(name(highest(person->rights)));
  const auto secret = source.make_login(clocks.now, *person, question.bearer);
  if (!secret)
    return error_text({"not_done", "this router has no keys, so nobody has to log in",
                       "open http://127.0.0.1:8080 on its host; see security.keys"});
  json::object out = answer_frame(source, clocks, "tims/login_made/1");
  out["user"] = base::valid_utf8(person->name);
  out["right"] = right;
  out[question.bearer ? "bearer" : "token"] = *secret;
  out["http"] = source.process(clocks.now).http;
  return json::serialize(out);
}

std::optional<QuestionError> change_lease(const Question& question, core::ClientId asker,
                                          const Header& request, AdminSource& source, Time now) {
  if (auto elsewhere = lease_elsewhere(question, asker, source.router())) return elsewhere;
  const core::DrivingLease holder{.robot = *question.robot,
                                  .holder = std::string_view(question.holder),
                                  .mailbox = question.mailbox.value_or(request.src),
                                  .stick = question.stick.value_or(Address())};
  // Its messages come from the owner of its mailbox.
  const core::Table::Entry* owned =
      question.mailbox ? source.router().find(*question.mailbox) : nullptr;
  const core::LeaseResult result =
      source.change_lease(now, owned == nullptr ? asker : owned->owner, question.lease, holder);
  if (result == core::LeaseResult::kDone) return std::nullopt;
  const core::DrivingLease* other = source.router().leases().find(*question.robot);
  const std::string robot = fmt::format("robot {}", *question.robot);
  if (result == core::LeaseResult::kTaken)
    return QuestionError{"lease_taken", fmt::format("{} drives {}", other->holder.view(), robot),
                         "take_over takes the lease from its holder; ask it first"};
  if (result == core::LeaseResult::kTooMany) return not_done("there are too many driving leases");
  return QuestionError{"lease_not_held",
                       other == nullptr ? fmt::format("the driving lease of {} has ended", robot)
                                        : fmt::format("{} drives {}", other->holder.view(), robot),
                       "take it again"};
}

std::string lease_text(const Question& question, const AdminSource& source, const Clocks& clocks) {
  json::object out = answer_frame(source, clocks, "tims/done/1");
  out["done"] = true;
  out["left_s"] = question.lease == core::LeaseVerb::kRelease
                      ? json::value()
                      : json::value(base::seconds(core::DrivingLeases::kTime));
  return json::serialize(out);
}

std::vector<core::StaticRoute> reload_routes(const std::vector<core::StaticRoute>& running,
                                             const std::vector<core::StaticRoute>& before,
                                             const std::vector<core::StaticRoute>& after) {
  std::vector<core::StaticRoute> routes;
  for (const core::StaticRoute& route : after)
    if (!has(before, route) || has(running, route)) routes.push_back(route);
  for (const core::StaticRoute& route : running)
    if (!has(before, route) && !has(routes, route)) routes.push_back(route);
  return routes;
}

}  // namespace tims::io
