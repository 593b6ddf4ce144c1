#include "router/io/admin_actions.h"

#include <algorithm>
#include <string>

#include "router/config/nearest.h"

namespace tims::io {
namespace {

using link::Links;

Links::Hand hand_of(std::string_view action) {
  if (action == "up") return Links::Hand::kUp;
  return action == "down" ? Links::Hand::kDown : Links::Hand::kReset;
}

// A route over a link that is not there would take messages away, and say nothing.
std::optional<QuestionError> no_link(const AdminSource& source, std::string_view name) {
  std::vector<std::string_view> known;
  if (const Links* links = source.links())
    links->for_each([&](const link::Link& link) {
      if (!link.peer().name.view().empty()) known.push_back(link.peer().name.view());
    });
  if (std::ranges::find(known, name) != known.end()) return std::nullopt;
  std::string hint = "this router has no links: [[link]] in its configuration";
  if (const auto near = config::nearest(name, known)) {
    hint = "did you mean " + std::string(*near) + "?";
  } else if (!known.empty()) {
    hint = "there are";
    for (const std::string_view other : known)
      hint.append(other == known.front() ? " " : ", ").append(other);
  }
  return QuestionError{"no_such_link", "no link to a router \"" + std::string(name) + "\"", hint};
}

std::optional<QuestionError> not_done(std::string why) {
  if (why.empty()) return std::nullopt;
  return QuestionError{"not_done", std::move(why)};
}

std::optional<QuestionError> change_routes(const Question& question, const AdminSource& source) {
  std::vector<core::StaticRoute> routes = source.router().static_routes();
  const std::size_t gone = std::erase_if(routes, [&](const core::StaticRoute& route) {
    return route.text.view() == question.pattern &&
           (question.link.empty() || route.via.view() == question.link);
  });
  if (question.ask == Ask::kRouteAdd) {
    if (question.link.empty())
      return not_done("\"via\" is missing: the name of a router on a link");
    if (auto wrong = no_link(source, question.link)) return wrong;
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

bool has(const std::vector<core::StaticRoute>& routes, const core::StaticRoute& route) {
  return std::ranges::any_of(routes, [&](const core::StaticRoute& other) {
    return other.text.view() == route.text.view() && other.via.view() == route.via.view();
  });
}

}  // namespace

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

std::optional<QuestionError> carry_out(const Question& question, const AdminSource& source) {
  switch (question.ask) {
    case Ask::kLinkDo:
      return not_done(source.act_on_link(question.link, hand_of(question.action)));
    case Ask::kFault:
      return not_done(source.spoil(question.link, question.faults));
    default:
      return change_routes(question, source);
  }
}

}  // namespace tims::io
