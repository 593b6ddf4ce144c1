#include "router/io/admin_actions.h"

#include <algorithm>

namespace tims::io {
namespace {

using link::Links;

Links::Hand hand_of(std::string_view action) {
  if (action == "up") return Links::Hand::kUp;
  return action == "down" ? Links::Hand::kDown : Links::Hand::kReset;
}

std::string change_routes(const Question& question, const AdminSource& source) {
  std::vector<core::StaticRoute> routes = source.router().static_routes();
  const std::size_t gone = std::erase_if(routes, [&](const core::StaticRoute& route) {
    return route.text.view() == question.pattern &&
           (question.link.empty() || route.via.view() == question.link);
  });
  if (question.ask == Ask::kRouteAdd) {
    if (question.link.empty()) return "\"via\" is missing: the name of a router on a link";
    if (routes.size() >= kStaticRoutesMax)
      return "there are " + std::to_string(kStaticRoutesMax) + " static routes already";
    routes.push_back(
        {question.match, std::string_view(question.pattern), std::string_view(question.link)});
  } else if (gone == 0) {
    return "no static route for \"" + question.pattern + "\"";
  }
  source.set_static_routes(routes);
  return {};
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

std::string carry_out(const Question& question, const AdminSource& source) {
  switch (question.ask) {
    case Ask::kLinkDo:
      return source.act_on_link(question.link, hand_of(question.action));
    case Ask::kFault:
      return source.spoil(question.link, question.faults);
    default:
      return change_routes(question, source);
  }
}

}  // namespace tims::io
